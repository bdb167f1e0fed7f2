/** Types that several modules share: of answers of the service, and of arguments. */

export type * from "./answers.js";
export type { Fault } from "./api.js";
export type { Quantity } from "./axis_field.js";
export type { Answered, Scale } from "./design_figures.js";
export type { Found, Marked } from "./designs.js";
export type { Held } from "./document_form.js";
export type { Figure, Layout, Trace } from "./figure.js";
export type { Drawn, Titles } from "./figure_table.js";
export type { Filter } from "./filter.js";
export type { History } from "./history.js";
export type { Kept } from "./kept.js";
export type { View } from "./main.js";
export type { Selection } from "./selection.js";
export type { Best } from "./shelf.js";
export type { Shown } from "./shown.js";
export type { Session, Tab } from "./study.js";
export type { FittedField, SpecifiedField } from "./words.js";

/** Content of an element; lists may be nested. */
export type Child = Node | string | number | null | undefined | false | Child[];
