"""How every test draws its examples: the same ones each time, so that no run fails by chance.

`HYPOTHESIS_PROFILE=explore` draws others on every run, to look for what these leave out.
"""

import os

from hypothesis import settings

settings.register_profile("fixed", derandomize=True, deadline=None, print_blob=True)
settings.register_profile("explore", deadline=None, max_examples=1000, print_blob=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "fixed"))
