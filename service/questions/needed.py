"""Modules that answer questions. A service imports these modules after its start, before the first question."""

import damperlab.studies.answers.frequency_response
import damperlab.studies.answers.map_difference
import damperlab.studies.answers.phrases
import damperlab.studies.answers.ranking
import damperlab.studies.answers.resonance_map
import damperlab.studies.answers.tmd_comparison
import damperlab.studies.answers.window
import damperlab.studies.store.cube.opened  # noqa: F401
