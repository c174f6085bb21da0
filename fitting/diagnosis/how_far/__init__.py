"""How far the gap shrinks, on runs or segments that took no part."""
