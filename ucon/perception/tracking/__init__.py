"""From labelled boxes to tracked things: which pixels are the thing, and which thing it is."""
