"""The store of a process that computes for requests."""

from functools import lru_cache

from damperlab.service.settings import Settings
from damperlab.studies.store.store import Store


@lru_cache(maxsize=1)
def store_of(settings: Settings) -> Store:
    """Open the store that the settings name, once in this process."""
    return settings.open_store(wait_seconds=settings.catalogue_wait_seconds)
