"""Learning from counterfactual rollouts: what would have come of going to other views?"""
