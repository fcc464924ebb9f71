"""How thoroughly hypothesis looks: `HYPOTHESIS_PROFILE=thorough` for much more of it."""

import os

from hypothesis import HealthCheck, settings

_common = {
    "deadline": None,  # the machine has other things to do
    "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large],
}
settings.register_profile("quick", max_examples=25, derandomize=True, database=None, **_common)
settings.register_profile("thorough", max_examples=3000, **_common)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "quick"))
