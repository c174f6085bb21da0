"""The diagnosis: where simulation and records part, which effect causes it, how far the gap closes.

`diagnose` is the whole of it, `inquiry` one look at a data set, and `turns` what that goes through;
`findings` is what comes out, `save` writes it and `words` says it. Lowest first, each of what they rest on
imports from itself and from below:

    judging     from misfits to probabilities and a verdict
    lanes       records cut into lanes, and the compiled model that simulates them all with any effects
    refits      hypotheses fitted to lanes, and how sure what they find is
    noise       what does not repeat itself, which no model is asked to explain
    how_far     how far the gap shrinks, on runs or segments that took no part
    unlisted    signs of what no effect on the shelf does
    which       the search: one effect after another, and two together
    where       where simulation and records part, and what the gap follows
"""
