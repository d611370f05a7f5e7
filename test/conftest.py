"""Settings of all tests: hypothesis tries the same examples in every run."""

from hypothesis import settings
import pytest

settings.register_profile('repeatable', derandomize=True, database=None, deadline=None)
settings.load_profile('repeatable')


@pytest.fixture
def unmeasured(monkeypatch):
    """Measure no coverage in the processes that a test starts: they cannot write its file."""
    monkeypatch.delenv('COVERAGE_PROCESS_CONFIG', raising=False)
