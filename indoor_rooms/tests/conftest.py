"""Settings of all tests."""

import hypothesis

# Tests do not measure time: on a busy machine a deadline is only a way to fail.
hypothesis.settings.register_profile("untimed", deadline=None)
hypothesis.settings.load_profile("untimed")
