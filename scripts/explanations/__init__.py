"""The figures of the explanations in docs/, each a module; `scripts/draw_explanations.py` writes or checks them."""
