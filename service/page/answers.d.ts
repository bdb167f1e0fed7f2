/** What the service answers, as far as the page reads it. */

/**
 * A study as it is kept, its phase and time left while it has any; a list leaves `definition` and
 * `provenance` out.
 */
export type StudyRecord = {
  id: string;
  name: string;
  state: string;
  phase: string;
  phase_done: number;
  phase_total: number;
  points_total: number;
  points_done: number;
  points_failed: number;
  points_reused: number;
  blocks_done: number;
  created: string;
  finished: string | null;
  seconds_left: number;
  kernel_seconds: number;
  message: string | null;
  revision: number;
  shape: number[];
  dimensions: string[];
  outdated: boolean;
  priority: number;
  tags: string[];
  note: string;
  submitted_by: string | null;
  /** As it was submitted: the service judges which keys it has. */
  definition: any;
  provenance?: { solver_version?: string };
};

/** A result variable. */
export type Variable = { name: string; long_name: string; units: string; doc: string; coded: boolean };

/** What a study can be made of, and what its results mean. */
export type Catalogue = {
  variables: Variable[];
  suite: { variables: Variable[] };
  studies: Example[];
  specifications: Example[];
  objectives: Record<string, string>;
  respects: Record<string, string>;
  tunings: Record<string, string>;
  status: Record<string, string>;
  response_class: Record<string, { name: string; doc: string }>;
};

/** A named study or specification to start from. */
export type Example = { name: string; about: string[]; definition: Record<string, unknown> };

/** A ground-motion record as it is listed. */
export type GroundRecord = { id: string; name: string; peak_acceleration_g: number; duration_s: number };

/** A result over two dimensions; what is not there is null. */
export type MapAnswer = {
  x: number[];
  y: number[];
  values: (number | null)[][];
  metric: string;
  units: string;
  long_name: string;
  x_dimension: string;
  y_dimension: string;
  x_title?: string;
  y_title?: string;
  complete: number;
  /** How the other dimensions are reduced. */
  reduce: string;
  /** Names of codes, by the variable that is coded. */
  meanings: Record<string, Record<string, string>>;
  response_class?: number[][];
  status?: number[][];
  /** Of a map less another one. */
  other: (number | null)[][];
  difference: (number | null)[][];
};

/** The worst case of a damper. */
export type Worst = {
  measure: string;
  units: string;
  value: number;
  frequency_hz?: number | null;
  frequency_ratio?: number | null;
  record?: string | null;
  record_name?: string | null;
  scale?: number | null;
};

/** A damper as it is built, by the names of its quantities. */
export type Built = Record<string, number | null>;
