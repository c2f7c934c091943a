import { part } from "./part.ts";

/**
 * The page's texts for each fault (web/stream/faults.ts). title: what happened, also as the first
 * sentence of a banner. text: what it means, and what to do; NAME stands for the volume's name or the
 * store's address.
 */
export const faultTexts = /* @__PURE__ */ part("fault", {
  unreachable: {
    title: "The server does not answer",
    text: "“NAME” cannot be reached: the server may be starting, or the connection is down. The page retries automatically.",
  },
  "server-fault": {
    title: "The server answers with an error",
    text: "It may be starting, overloaded, or out of order. The page retries “NAME” automatically.",
  },
  "cors-refused": {
    title: "This host does not let other sites read its files",
    text: "The host of “NAME” responds, but does not allow this page to read the response (CORS); or the file does not exist. Its operator must send “Access-Control-Allow-Origin: *” with every response, including errors (nginx: add_header … always; isosplat serve: --cors), and should send “Access-Control-Expose-Headers: Content-Range, Content-Length, ETag”.",
  },
  "access-denied": {
    title: "The server refuses access",
    text: "“NAME” is not public, or does not exist. Open the complete address or link that you received; it may have expired. Or ask the owner of “NAME” for access.",
  },
  "not-found": {
    title: "No such volume",
    text: "There is no volume “NAME”. It may have been renamed or removed. If it comes back, the page opens it automatically.",
  },
  replaced: {
    title: "The volume was replaced",
    text: "“NAME” is another store now. The page opens it automatically.",
  },
  "cut-short": {
    title: "The store was cut short",
    text: "The file of “NAME” is shorter than its header states. Copy the whole file again, or rebuild it with “isosplat build”.",
  },
  "no-range": {
    title: "This host does not serve parts of files",
    text: "Isosplat reads stores in pieces, by HTTP Range requests, but this host responds with the whole file, which works only for stores of up to 16 MB. Put the store on a host that supports Range (nginx, S3 and most object stores do), or serve it with “isosplat serve”.",
  },
  "not-a-store": {
    title: "This is not a store",
    text: "The file at the address of “NAME” is not an Isosplat store. Check the address, or build a store with “isosplat build”.",
  },
  "newer-version": {
    title: "This store is newer than this page",
    text: "“NAME” was made by a newer version of Isosplat than this page. Open it with that version, or rebuild it with this one.",
  },
  "damaged-header": {
    title: "The store is damaged",
    text: "The header of “NAME” has changed since it was written. Copy the store again, or rebuild it with “isosplat build”.",
  },
  "damaged-page": {
    title: "The store is damaged",
    text: "A part of its directory arrived twice with a wrong checksum; the rest is shown. Copy the store again, or rebuild it with “isosplat build”.",
  },
  "damaged-part": {
    title: "The store is damaged",
    text: "Parts of it arrived twice with a wrong checksum; coarser parts are shown instead. Copy the store again, or rebuild it with “isosplat build”.",
  },
  "out-of-memory": {
    title: "The memory is full",
    text: "The picture is coarser than the screen can show. Close other programs or tabs, and try again.",
  },
  "worker-lost": {
    title: "The browser stopped a worker that decodes data",
    text: "The browser may be short of memory. The worker is restarted automatically. If this message stays, close other tabs.",
  },
  "no-webgl2": {
    title: "This browser offers no WebGL 2",
    text: "Isosplat draws with WebGL 2. Switch on hardware acceleration in the browser's settings, update the graphics driver, or open this address in a current Firefox, Chrome, Edge or Safari.",
  },
  "context-lost": {
    title: "The browser took the graphics card away",
    text: "The picture returns when the browser makes it available again.",
  },
  "renderer-failed": {
    title: "The picture cannot be drawn",
    text: "The graphics driver reported an error. Try again; if that does not help, restart the browser.",
  },
  "bad-address": {
    title: "This is not the address of a store",
    text: "“NAME” cannot be fetched. Give the http or https address of a store, such as https://example.org/head.isosplat.",
  },
  internal: {
    title: "Something went wrong",
    text: "This is a fault of the page, not of your data. Reload the page. If the fault comes back, report the details.",
  },
});
