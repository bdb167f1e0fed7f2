// The main journey with a client that @hey-api/openapi-ts made from /openapi.json alone: compiled strictly, run by node.

import {
  askDesignsApiV1StudiesStudyIdOptimalDesignsGet as designs,
  askMapApiV1StudiesStudyIdResonanceMapGet as map,
  deleteApiV1StudiesStudyIdDelete as remove,
  showApiV1StudiesStudyIdGet as show,
  submitApiV1StudiesPost as submit,
} from "./client";
import { client } from "./client/client.gen";
import type { Problem, Record, Study } from "./client";

declare const process: { argv: string[]; exitCode: number };

client.setConfig({ baseUrl: process.argv[2], auth: () => process.argv[3] });

const study: Study = {
  name: "generated client",
  particle: false,
  damping_ratio: 0.0123,
  axes: { friction_ratio: [0, 0.1], frequency_ratio: { start: 0.5, stop: 1.5, num: 11 } },
};

async function journey(): Promise<object> {
  const foreseen = await submit({ body: study, query: { dry_run: true } });
  if (!foreseen.data || !("points" in foreseen.data)) throw new Error("no estimate");
  const submitted = await submit({ body: study });
  if (!submitted.data || !("id" in submitted.data)) throw new Error(JSON.stringify(submitted.error));
  const study_id = submitted.data.id;
  let record: Record = submitted.data as Record;
  while (record.state === "queued" || record.state === "running") {
    await new Promise((resolve) => setTimeout(resolve, 100));
    record = (await show({ path: { study_id }, throwOnError: true })).data;
  }
  const path = { study_id };
  const seen = await map({ path, query: { x: "frequency_ratio", y: "friction_ratio" }, throwOnError: true });
  const best = await designs({ path, query: { objective: "peak", top: 1 }, throwOnError: true });
  const refused = await map({ path, query: { x: "clearance_ratio" } });
  const problem: Problem | undefined = refused.error;
  let removed = await remove({ path });
  while (removed.response?.status === 409) {
    await new Promise((resolve) => setTimeout(resolve, 100)); // its runner lets it go in a moment
    removed = await remove({ path });
  }
  const gone = await show({ path });
  return {
    points: foreseen.data.points,
    created: submitted.response?.status,
    state: record.state,
    x: seen.data.x,
    values: seen.data.values,
    best: best.data.designs[0],
    refused: { status: problem?.status, fields: problem?.errors?.map((fault) => fault.field) },
    removed: removed.response?.status,
    gone: gone.error?.status,
  };
}

journey().then(
  (found) => console.log(JSON.stringify(found)),
  (error) => {
    console.error(error);
    process.exitCode = 1;
  },
);
