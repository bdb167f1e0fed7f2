/**
 * A field of a specification: its name, what people call it, its unit, what a value is multiplied with to be
 * in that, and what is meant where nothing is said.
 */
export type SpecifiedField = { name: string; label: string; unit: string; scale: number } & Usual;
type Usual = { usual_value?: number | null };

/** A quantity of a prototype: its place in what is known, whether it may be sought, and is usually. */
export type FittedField = SpecifiedField & { path: string; free: boolean; usual: boolean };

/**
 * The module `words.js`, which `service/page/words.py` writes: the words of the service that the page
 * shows.
 */
export const WORDS: {
  /** The questions to a study: by which kinds of study each is answered, and its name behind every door. */
  questions: { summary: string; route: string; command: string; method: string; kinds: string[] }[];
  /** Symbols of the dimensions of a harmonic study, as the paper writes them. */
  symbols: Record<string, string>;
  /** Dimensions that every harmonic study has. */
  dimensions: string[];
  /** Dimensions that only some have, with what of a physical block makes them. */
  before: Record<string, string>;
  /** Names for people of every dimension, those of ground-motion suites too. */
  names: Record<string, string>;
  /** Units that dimensions in SI are shown in: lengths in mm. */
  units: Record<string, string>;
  /** Dimensions without meaning if there is no particle. */
  of_particle: string[];
  /**
   * Dimensions in the order in which a map shows them, of a harmonic study, of a suite and of a study over
   * base amplitudes.
   */
  axes: string[];
  tag_pattern: string;
  tag_words: string;
  suite_axes: string[];
  amplitude_axes: string[];
  /** Dimensions of a suite, and of a study over base amplitudes, that a designer chooses. */
  damper: string[];
  amplitude_damper: string[];
  /**
   * Results that a study over base amplitudes has in units: the ratio that each stands for, its name for
   * people, its unit.
   */
  results_in_units: Record<string, [string, string, string]>;
  /** The design point that is computed where nothing else is said. */
  design_point: Record<string, number>;
  /** The paper's prototype in SI units, and its structure alone. */
  prototype: Record<string, number>;
  structure: { mass_kg: number; natural_frequency_hz: number; base_amplitude_m: number };
  /** Physical quantities by the ratio that each makes. */
  stands_for: Record<string, string>;
  /** What stands in units for a ratio: symbol, name, unit, and that unit in units of SI. */
  in_units: Record<string, [string, string, string, number]>;
  /** What designs may be judged by, where amplitudes are in units. */
  objectives_in_units: Record<string, string>;
  /** Where the number of each respect in which designs may be compared comes from. */
  respects: Record<string, string>;
  /** Results of which less is better: amplitudes and accelerations. */
  judged: string[];
  /** What each result that is a ratio is over. */
  over: Record<string, string>;
  /** Errors below this share of their value are rounding, and what a table says of them. */
  rounding: { share: number; word: string };
  /** The name by which a ratio is asked for in SI units. */
  names_in_si: Record<string, string>;
  /** States of a study, and those at which nothing more happens by itself. */
  states: string[];
  ended: string[];
  /** Names for people, by the name in documents. */
  excitations: Record<string, string>;
  contact_models: Record<string, string>;
  start_kinds: Record<string, string>;
  criteria: Record<string, string>;
  /** Units that an acceleration may be given in. */
  acceleration_units: string[];
  export_formats: Record<string, string>;
  /** When a response counts as steady, where a study says nothing. */
  steady: { max_cycles: number; tolerance: number };
  /** The fields of a specification. */
  specification: {
    /** `usual`: shown though it is not given; `loose`: has a tolerance. */
    structure: (SpecifiedField & { usual: boolean; loose: boolean })[];
    /** `most`: how many there may be. */
    excitation: {
      motions: SpecifiedField[];
      frequency: SpecifiedField[];
      sweep: { ends: SpecifiedField[]; paces: SpecifiedField[]; amplitudes: SpecifiedField[] };
      random_vibration: { frequency: SpecifiedField; levels: SpecifiedField[]; numbers: SpecifiedField[] };
      shock: { shapes: Record<string, string>; numbers: SpecifiedField[] };
      most: number;
      tail: SpecifiedField;
    };
    /** Quantities of the damper, each with its name in a table and the ratio that may stand for it. */
    damper: (SpecifiedField & { ratio: string; called: string })[];
    /** What acts on a particle in its cavity, likewise; neither is made by one ratio alone. */
    cavity: (SpecifiedField & { ratio: string; called: string })[];
    ratios: Record<string, SpecifiedField>;
    contact_time: SpecifiedField;
    /** `over_bands`: whether they hold over bands alone, and not under ground-motion records. */
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
  /** Everything that may be known of a prototype, or be sought. */
  fitted: FittedField[];
};
