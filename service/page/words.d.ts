/**
 * A field of a specification: its name, its label, its unit, the factor from the stored value to that unit,
 * and the value of an empty field.
 */
export type SpecifiedField = { name: string; label: string; unit: string; scale: number } & Usual;
type Usual = { usual_value?: number | null };

/** A quantity of a prototype: `path` in a study, `free` to be estimated, `usual` if always shown. */
export type FittedField = SpecifiedField & { path: string; free: boolean; usual: boolean };

/** The module `words.js`, which `service/page/words.py` writes. */
export const WORDS: {
  /** The questions to a study: the kinds of study that answer each, and its name in every interface. */
  questions: { summary: string; route: string; command: string; method: string; kinds: string[] }[];
  /** Symbols of the dimensions of a harmonic study, as the paper writes them. */
  symbols: Record<string, string>;
  /** Dimensions that every harmonic study has. */
  dimensions: string[];
  /** Dimensions that only some harmonic studies have, each with its quantity in a physical block. */
  before: Record<string, string>;
  /** Readable names of every dimension, including those of ground-motion suites. */
  names: Record<string, string>;
  /** Units in which dimensions in SI are shown: lengths in mm. */
  units: Record<string, string>;
  /** Dimensions without meaning if there is no particle. */
  of_particle: string[];
  /** Dimensions in the order in which a map of each kind of study shows them. */
  axes: string[];
  tag_pattern: string;
  tag_words: string;
  suite_axes: string[];
  amplitude_axes: string[];
  /** Dimensions of a suite, and of a study over base amplitudes, that a designer chooses. */
  damper: string[];
  amplitude_damper: string[];
  /** Results in units of a study over base amplitudes: the ratio, the name and the unit of each. */
  results_in_units: Record<string, [string, string, string]>;
  /** The default design point. */
  design_point: Record<string, number>;
  /** The paper's prototype in SI units, and its structure alone. */
  prototype: Record<string, number>;
  structure: { mass_kg: number; natural_frequency_hz: number; base_amplitude_m: number };
  /** Physical quantities by the ratio that each defines. */
  stands_for: Record<string, string>;
  /** The quantity in units for each ratio: symbol, name, unit, and the factor from SI to that unit. */
  in_units: Record<string, [string, string, string, number]>;
  /** Criteria for judging designs, if amplitudes are in units. */
  objectives_in_units: Record<string, string>;
  /** The variable or dimension of each respect in which designs may be compared. */
  respects: Record<string, string>;
  /** Results that should be small: amplitudes and accelerations. */
  judged: string[];
  /** The reference of each result that is a ratio. */
  over: Record<string, string>;
  /** Errors up to this share of their value are rounding; a table shows the word instead. */
  rounding: { share: number; word: string };
  /** The name under which a ratio is requested in SI units. */
  names_in_si: Record<string, string>;
  /** States of a study, and those in which it has ended. */
  states: string[];
  ended: string[];
  /** Readable names, by the name in documents. */
  excitations: Record<string, string>;
  contact_models: Record<string, string>;
  start_kinds: Record<string, string>;
  criteria: Record<string, string>;
  /** Allowed units of an acceleration. */
  acceleration_units: string[];
  export_formats: Record<string, string>;
  /** Default settings for a steady response. */
  steady: { max_cycles: number; tolerance: number };
  /** The fields of a specification. */
  specification: {
    /** `usual`: shown even if it is not given; `loose`: has a tolerance. */
    structure: (SpecifiedField & { usual: boolean; loose: boolean })[];
    /** `most`: largest number of excitations. */
    excitation: {
      motions: SpecifiedField[];
      frequency: SpecifiedField[];
      sweep: { ends: SpecifiedField[]; paces: SpecifiedField[]; amplitudes: SpecifiedField[] };
      random_vibration: { frequency: SpecifiedField; levels: SpecifiedField[]; numbers: SpecifiedField[] };
      shock: { shapes: Record<string, string>; numbers: SpecifiedField[] };
      most: number;
      tail: SpecifiedField;
    };
    /** Quantities of the damper, each with its name in a table and the ratio that may replace it. */
    damper: (SpecifiedField & { ratio: string; called: string })[];
    /** Quantities of the cavity, likewise; neither corresponds to one ratio alone. */
    cavity: (SpecifiedField & { ratio: string; called: string })[];
    ratios: Record<string, SpecifiedField>;
    contact_time: SpecifiedField;
    /** `over_bands`: whether they apply only over bands, and not under ground-motion records. */
    limits: (SpecifiedField & { over_bands: boolean })[];
    numbers: SpecifiedField[];
    tables: {
      measures: Record<string, string>;
      measures_under_records: Record<string, string>;
      at_a_frequency: Record<string, string>;
      /** Names of measures that are accelerations; the others are displacements. */
      accelerations: string[];
    };
  };
  /** Every quantity of a prototype that may be known or estimated. */
  fitted: FittedField[];
};
