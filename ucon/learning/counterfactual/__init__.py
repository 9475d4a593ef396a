"""Learning from counterfactual rollouts: what would going to other views have led to?"""
