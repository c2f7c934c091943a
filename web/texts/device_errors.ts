import { part } from "./part.ts";

/** Why files of this device, or at an address, cannot be opened, kept or saved. */
export const deviceErrorTexts = part("deviceError", {
  corsRemedy:
    "or the file does not exist. Its operator must send “Access-Control-Allow-Origin: *” (CORS); or download the file, and drop it here",
  notFoundRemedy: "check the address",
  accessRemedy: "open the complete link that you received, or download the file and drop it here",
  unreachableRemedy: "check the address and your connection, and open it again",
  serverRemedy: "open it again later",
  webPage: (address: string, type: string) =>
    `${address}: expected a volume's file, found a web page (${type}): give the address of the file itself.`,
  replaced: (address: string) =>
    `${address}: the file was replaced while it was fetched: open it again.`,
  tooLarge: (name: string, most: string, found: string) =>
    `${name}: expected at most ${most}, found ${found}: download it, and build its store with the program: isosplat build ${name}`,
  tooManyFiles: (most: number) =>
    `expected at most ${most} files, found more: drop the folder of one volume alone`,

  keptSize: (stated: number, found: number) => `expected ${stated} bytes, found ${found}`,
  notAllowed: "This browser does not let pages keep files on this device.",
  notKept: (reason: string) => `The browser did not keep the store on this device: ${reason}.`,
  notRemoved: (name: string, reason: string) =>
    `The browser did not remove ${name}: ${reason}. Close other tabs that have it open, and try again.`,
  noRoom: (needed: string, found: string) =>
    `Expected ${needed} of room for this site on this device, found ${found}: remove other volumes from this device, or save this one to a file.`,
  less: "less",

  /** Why a volume cannot be read, by the status of the core's error. */
  causes: {
    truncated: "The file is incomplete, or its header is wrong.",
    malformed_volume: "The file cannot be read as it is.",
    unsupported_format: "Isosplat cannot read this file.",
    unsupported_type: "Isosplat cannot read voxels of this type.",
    no_cells: "A volume needs at least two voxels along each axis.",
    volume_too_large: "The volume has too many voxels.",
    out_of_memory: "The memory of the browser is too small.",
    io_error: "The browser could not read the file.",
    worker_lost: "The browser ended the reading.",
  },

  noPageFiles: (status: number) =>
    `files.json: expected the list of this page's files, found status ${status}: load the page anew`,
  noPageFile: (name: string, status: number) =>
    `${name}: expected a file of this page, found status ${status}: the page was updated on its server; load it anew`,
  pageFileUnreachable: (name: string) =>
    `${name}: expected a file of this page, found no network: save it once the server can be reached`,
  tooLargeForPage: (most: string, found: string) =>
    `expected a store of at most ${most} for a single page, found ${found}: save a web site instead`,

  zipFiles: (most: number) =>
    `expected at most ${most} files, found more: unpack it, and drop the folder of one volume`,
  zipTooLarge: (most: string, found: string) =>
    `expected at most ${most} when it is unpacked, found at least ${found}: unpack it, and drop the folder`,
  zipDirectory: "its directory is too long: unpack it, and drop the folder of one volume",
  zipLonger: (name: string) =>
    `${name} is longer than it states: the archive is damaged; copy or download it again`,
  zipShorter: (name: string) =>
    `${name} is shorter than it states: the archive is damaged; copy or download it again`,
  zipDamaged: "the archive is damaged; copy or download it again",
  zipIncomplete: "it is no ZIP, or incomplete: copy or download it again",
  zipEncrypted: "it is encrypted: unpack it, and drop the folder",
  zipSplit: "it is one of several parts: unpack it, and drop the folder",
  zipUnsafe:
    "a file in it has a path outside of its folder: unpack it, and drop the folder if you trust it",
  zipCompression:
    "it is compressed in a way that browsers do not read: unpack it, and drop the folder",
});
