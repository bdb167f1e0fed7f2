/** The parts of the service's answers that the page reads. An unknown number is null. */

/** The answer to a request at a path. */
export type Answer<Path extends string> = Path extends `studies/${string}/${infer Question}`
  ? Question extends keyof OfStudy
    ? OfStudy[Question]
    : StudyRecord
  : Path extends `studies/${string}`
    ? StudyRecord
    : Path extends `designs/${string}`
      ? Design
      : Path extends `records/${string}`
        ? GroundRecordShown
        : Path extends keyof Others
          ? Others[Path]
          : unknown;

export type OfStudy = {
  /** `in_units`: the factor from each ratio to SI units. */
  axes: { axes: Axes; variables: string[]; in_units: Record<string, number> };
  fragility: Fragility;
  "frequency-response": Curve;
  "optimal-designs": Ranking;
  refine: Refinement;
  "particle-friction": Refinement;
  "resonance-map": MapAnswer;
  "tmd-comparison": Comparison;
};

export type Others = {
  accuracy: AccuracyReport;
  "accuracy/reports": { reports: unknown[] };
  catalog: Catalogue;
  designs: { designs: DesignSummary[]; cursor: string | null };
  "earthquake-comparisons": Earthquake;
  records: { records: GroundRecord[] };
  session: { needed: boolean; signed_in: boolean; owner: string };
  simulate: Simulated;
  studies: { studies: StudyRecord[]; cursor: string | null };
};

/** One quantity of a study: a value, values, or a range. */
export type Spec =
  | number
  | number[]
  | { start: number; stop: number; num: number; spacing?: string };

/** A study as it is submitted; the service checks its keys. */
export type Definition = {
  name?: string;
  particle?: boolean;
  axes: Record<string, Spec>;
  physical?: Record<string, Spec>;
  damping_ratio?: Spec;
  excitation?: string;
  contact?: { model: string; contact_time?: number };
  start?: string | { kind: string; n?: number; direction?: string };
  steady?: { max_cycles?: number; tolerance?: number };
  /** Values of a ground-motion suite. */
  records?: unknown;
  mass_kg?: number;
  tail_s?: number;
  starts?: number;
  /** What acts on the particle between impacts. */
  [name: string]: unknown;
};

/** An entry of a list: a study or a design. */
export type Listed = { id: string; name: string; state: string; created: string; message: string | null };

/** A study as it is stored; a list leaves `definition` and `provenance` out. */
export type StudyRecord = Listed & {
  phase: string;
  phase_done: number | null;
  phase_total: number | null;
  points_total: number;
  points_done: number;
  points_failed: number;
  points_reused: number;
  blocks_done: number;
  finished: string | null;
  seconds_left: number | null;
  kernel_seconds: number;
  revision: number;
  shape: number[];
  dimensions: string[];
  outdated: boolean;
  priority: number;
  tags: string[];
  note: string;
  submitted_by: string | null;
  definition: Definition;
  provenance?: { solver_version?: string };
};

/** Values along each dimension. Ids of records are texts; see `Selection.records`. */
export type Axes = Record<string, number[]>;

/** The expected cost of a study. */
export type Estimate = {
  points: number;
  blocks: number;
  bytes: number;
  seconds: number;
  seconds_low: number;
  seconds_high: number;
  compiling_seconds: number | null;
  understood: string[];
};

/** Whether kernels have to be compiled first. */
export type Readiness = { phase: string; phase_done: number; phase_total: number };

/** A result variable. */
export type Variable = { name: string; long_name: string; units: string; doc?: string; coded: boolean };

/** The parts of a study, and the meaning of its results. */
export type Catalogue = {
  variables: Variable[];
  suite: { variables: Variable[] };
  studies: Example[];
  specifications: Example[];
  objectives: Record<string, string>;
  respects: Record<string, string>;
  tunings: Record<string, string>;
  status: Record<string, string>;
  response_class: Record<string, { name: string; sentence: string }>;
};

/** A named study or specification to start from. */
export type Example = { name: string; about: string[]; definition: Record<string, unknown> };

/** A ground-motion record as it is listed. */
export type GroundRecord = {
  id: string;
  name: string;
  peak_acceleration_g: number;
  peak_acceleration_m_s2: number;
  duration_s: number;
};

/** A ground-motion record with its acceleration over time and its response spectrum. */
export type GroundRecordShown = GroundRecord & {
  step_s: number;
  damping_ratio: number;
  time_s: number[];
  acceleration_m_s2: number[];
  period_s: number[];
  pseudo_acceleration_m_s2: number[];
};

/** Sentences about an answer, in ratios and, if the study has units, also in units. */
export type Worded = Words & { in_units?: Words };
export type Words = { note?: string; verdict?: string[]; doubts?: Doubt[] };
export type Doubt = { kind: string; sentence: string };

export type Row = (number | null)[];

/** A result over two dimensions. */
export type MapAnswer = Worded & {
  x: number[];
  y: number[];
  values: Row[];
  metric: string;
  units: string;
  long_name: string;
  x_dimension: string;
  y_dimension: string;
  x_title?: string;
  y_title?: string;
  complete: number;
  points_failed: number;
  /** How the other dimensions are reduced. */
  reduce?: string;
  /** Names of codes, by the variable that is coded. */
  meanings: Record<string, Record<string, string>>;
  response_class?: number[][];
  status?: number[][];
};

/** The difference of two maps, and both maps. */
export type MapDifference = MapAnswer & {
  other: Row[];
  other_status?: number[][];
  other_response_class?: number[][];
  difference: Row[];
  /** Ids of both studies. */
  studies: string[];
};

/** A result over the frequency. */
export type Curve = {
  frequency_ratio: number[];
  values: Row;
  long_name: string;
  status: number[];
  amplitude_error?: Row;
  acceleration_g?: number;
  response_class?: number[];
};

/** A ranked damper: its coordinates and results by name, and its texts. */
export type Ranked = Record<string, number> & { response_class: string; record: string };

export type Frequencies = { start: number; stop: number; num: number };

/** The dampers of a study, the best first. */
export type Ranking = Worded & {
  designs: Ranked[];
  designs_total: number;
  units: string;
  long_name: string;
  /** The criterion by which designs of a harmonic study are judged. */
  objective: string;
  columns: Record<string, unknown>;
  best_with_impacts?: Ranked | null;
  brief: { damper: string | null };
  /** Whether friction clamps the structure with the best design. */
  clamped?: boolean;
  /** The band to compute, if only one frequency was computed. */
  next_frequencies?: Frequencies | null;
};

/** A damper compared with a tuned mass damper: curves over the frequency. */
export type Comparison = Worded &
  Curves & {
    /** The curves with a closed form, at more frequencies. */
    exact: Partial<Curves>;
    ratio: number | null;
    judged: boolean;
    criterion_means: string;
    next_frequencies?: Frequencies | null;
  };
export type Curves = { frequency_ratio: number[]; hybrid: Row; tmd: Row; no_damper: Row };

/** The probability that a damper exceeds a limit, over the scale of the records. */
export type Fragility = {
  note: string;
  records: number;
  scale: number[];
  exceeded: Row;
  probability: Row;
  median_scale?: number | null;
};

/** A search around the best damper of a study. */
export type Refinement = {
  found: Record<string, number>;
  known: boolean;
  steps: Record<string, number>;
  note: string;
  notes: { kind: string }[];
  follow_ups?: StudyRecord[];
};

/** One design point, computed. */
export type Simulated = {
  metrics: Record<string, number | null>;
  history: import("./history.js").Columns;
  spectrum: { multiple: number[]; amplitude: number[] };
  /** Forces on the structure, over k·Z. */
  forces: Record<string, number[]>;
};

/** Dampers under a ground-motion record. */
export type Earthquake = {
  record: GroundRecord;
  cases: Record<string, EarthquakeCase>;
  histories: Record<string, EarthquakeHistory>;
  note?: string;
};
/** The results with one damper, by name; `spread` holds the spread over other starts. */
export type EarthquakeCase = Record<string, number> & {
  label: string;
  spread?: Record<string, { lowest: number; highest: number }> & { sensitive: boolean };
};
export type EarthquakeHistory = {
  time_s: number[];
  relative_displacement_m: number[];
  absolute_displacement_m: number[];
  particle_displacement_m: Row;
  spectrum: { frequency_hz: number[]; amplitude_m: number[] };
  thinned: boolean;
};

/** The worst case of a damper. */
export type Worst = {
  measure: string;
  units: string;
  value: number;
  ratio?: number;
  frequency_hz?: number | null;
  frequency_ratio?: number | null;
  record?: string | null;
  record_name?: string | null;
  scale?: number | null;
};

/** A damper as it is built, by the names of its quantities. */
export type Built = Record<string, number | null>;

/** A damper, and its worst case. */
export type Known = { design: Built; worst: Worst; feasible: boolean };

/** A search for a damper as it is listed. */
export type DesignSummary = Listed & {
  stage: string | null;
  round: number;
  points: number;
  budget_points: number;
  known: Known | null;
};

/** The same with its answer once it is there. */
export type Design = DesignSummary & {
  points_of_round: number;
  studies: string[];
  studies_done: number;
  specification: Specification;
  answer: DesignAnswer | null;
};
export type Specification = Record<string, unknown> & { choose?: Record<string, unknown> };

/** The budget of a search for a damper. */
export type Budget = { chosen: string[]; budget_points: number; understood: string[] };

/** Frequencies, in hertz where the structure has units. */
export type Frequency = { frequency_ratio: number[]; frequency_hz?: number[] | null };
export type OverBand = Frequency & { value: Row | null };

/** Another damper beside the recommended one. */
export type OtherDamper = {
  worst: Worst;
  ratio: number;
  feasible?: boolean;
  detuned?: Worst;
  detuned_by?: number;
  response?: OverBand;
};
export type OtherName = "friction_alone" | "particle_alone" | "tuned_mass_damper";

export type DesignAnswer = Known & {
  specification: Specification;
  limits: unknown[];
  probability: number | null;
  /** Answers of earlier versions lack it. */
  verdict?: { damper: string | null; sentences: string[]; rows: string[][]; next: string };
  /** The name of the damper found, and the drawing of the verdict; earlier answers lack them. */
  called?: string;
  drawing?: string[][];
  words: string[];
  /** The worst case for the comparison with others, if it is not that over every tolerance. */
  compared?: Worst;
  response: OverBand;
  no_damper?: { response?: OverBand } | null;
  margins: Record<string, Record<"low" | "high" | "fails_below" | "fails_above", number | null>>;
  cases?: { record: string; record_name?: string; scale: number; value: number }[];
  amplitudes?: AtAmplitude[];
  masses?: OfMass[];
  starts?: {
    count: number;
    frequencies: number;
    several: number;
    where: { frequency_ratio: number; frequency_hz: number | null; responses: Met[] }[];
  } | null;
} & Record<OtherName, OtherDamper | null>;

/** The response of a damper at one amplitude of the excitation. */
export type AtAmplitude = Frequency & {
  amplitude: number;
  amplitude_units: string;
  asked: boolean;
  units: string;
  ratio: Row;
  worst_ratio: number;
  worst_frequency_hz: number | null;
  worst_frequency_ratio: number;
};

/** The best damper of one mass of the particle. */
export type OfMass = Known & {
  particle_mass_kg?: number;
  mass_ratio?: number;
  recommended: boolean;
  looked_at: number;
  tuned_mass_damper: number | null;
  particle_alone: number | null;
};

/** A response to which starts lead. */
export type Met = {
  displacement: number;
  share: number;
  response_class: string | null;
  from_rest?: boolean;
};

/** A prototype fitted to its measurement over frequency or over time. */
export type Fitted = {
  confidence: number;
  parameters: Record<string, { value: number; low: number; high: number; determined: boolean }>;
  words: string[];
  study: Definition | null;
  rows?: Record<"frequency" | "measured" | "model", number>[];
  units: Record<string, string>;
  time_s: number[];
  measured_m: number[];
  model_m: number[];
};

/** How exact and how fast the solver is. */
export type AccuracyReport = {
  created: string;
  version: string;
  machine?: { cores?: number };
  passed: boolean;
  diagrams: Diagram[];
  stability: Extreme[];
};
export type Diagram = { title: string; scene: string; curves: Method[] };
export type Method = {
  method: string;
  order: number | null;
  setting: string | null;
  points: { error: number | null; microseconds: number; setting: number }[];
};
export type Extreme = {
  name: string;
  passed: boolean;
  status: string;
  cycles: number;
  impacts: number;
  energy_residual: number | null;
  microseconds: number;
  paper: string;
};
