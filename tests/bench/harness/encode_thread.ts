/** A thread of Node that encodes blocks. It replaces web/builder/encode_worker.ts. */
import { parentPort, workerData } from "node:worker_threads";
import { type Port, serveEncoder } from "../../../web/builder/index.ts";

serveEncoder(workerData.port as Port, workerData.program);
// The thread lives until it is terminated.
parentPort?.on("message", () => {});
