/** Faults that do not end by themselves, for tests/browser/chaos.browser.ts. */
import { type FaultKind, faults } from "../../../web/stream/faults.ts";
import type { FaultProxy } from "../../support/fault_proxy.ts";

/** The connection between the page and the store. */
export interface Way {
  proxy: FaultProxy;
  /** Replaces the store by one with these changes; resolves when the server has noticed it. */
  change: (change: (bytes: Buffer) => Buffer) => Promise<void>;
}

export interface LastingFault {
  name: string;
  where: "both" | "nginx";
  /** Reloads the page, if an open page would report another fault or none. */
  isForNewPage?: boolean;
  begin: (way: Way) => void | Promise<void>;
  /** The fault that the page must report. */
  kind: FaultKind;
}

/** Whether this is the address of data, not of the page. */
export const isOfData = (path: string): boolean => /^\/v1\/|\.isosplat$/.test(path);

const answersWith = (status: number, kind: FaultKind): LastingFault => ({
  name: `status ${status}`,
  where: "both",
  begin: ({ proxy }) => {
    proxy.fault = (path) => (isOfData(path) ? { kind: "status", status } : undefined);
  },
  kind,
});

const isChanged = (
  name: string,
  kind: FaultKind,
  change: (bytes: Buffer) => Buffer,
): LastingFault => ({ name, where: "both", begin: (way) => way.change(change), kind });

export const lastingFaults: readonly LastingFault[] = [
  {
    name: "connection refused",
    where: "both",
    begin: ({ proxy }) => proxy.stop(),
    kind: "unreachable",
  },
  isChanged("damaged chunks", "damaged-part", (bytes) => {
    // The file consists of chunks, except for the header and the coarse tail at its end.
    for (let at = 0.1 * bytes.length; at < 0.7 * bytes.length; at += 600) {
      for (let i = Math.floor(at); i < at + 64; ++i) bytes[i] = (bytes[i] ?? 0) ^ 0x55;
    }
    return bytes;
  }),
  answersWith(404, "not-found"),
  {
    name: "no CORS",
    where: "nginx",
    // For a host that this page has read from, the page assumes that only error responses lack
    // CORS.
    isForNewPage: true,
    begin: ({ proxy }) => {
      proxy.fault = () => ({ kind: "without", field: /^access-control-/ });
    },
    kind: "cors-refused",
  },
  answersWith(503, "server-fault"),
  isChanged("not a store", "not-a-store", () => Buffer.from("no store at all. ".repeat(9000))),
  isChanged("cut short", "cut-short", (bytes) => bytes.subarray(0, 0.6 * bytes.length)),
  answersWith(403, "access-denied"),
  isChanged("a damaged header", "damaged-header", (bytes) => {
    bytes[100] = (bytes[100] ?? 0) ^ 1;
    return bytes;
  }),
  answersWith(500, "server-fault"),
];

export const titleOf = ({ kind }: LastingFault): string => faults[kind].title;
