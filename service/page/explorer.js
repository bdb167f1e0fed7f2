/** Explores a study: slices through the point, all designs together, and pinned points side by side. */
/** @import { Tab } from "./types.js" */

import { el, fill } from "./dom.js";
import { ParallelPanel } from "./parallel.js";
import { PinsPanel } from "./pins.js";
import { sliders } from "./sliders.js";
import { SlicesPanel } from "./slices.js";

/** @type {Tab} */
export function explorerTab(session, place) {
  const { selection } = session;
  const parts = [new SlicesPanel(session), new ParallelPanel(session), new PinsPanel(session)];
  fill(
    place,
    el(
      "div",
      { class: "explorer" },
      el(
        "section",
        { class: "box wide", "aria-label": "The design point" },
        sliders(selection, session.shown),
      ),
      parts.map((part) => part.element),
    ),
  );
  const look = () => place.isConnected && parts.forEach((part) => part.look());
  session.changes.addEventListener("grown", look);
  parts.forEach((part) => part.look());
}
