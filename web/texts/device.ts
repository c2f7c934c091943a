import { plurals } from "./numbers.ts";
import { part } from "./part.ts";

const plural = plurals("en");
const files = (n: number) => plural(n, { one: `${n} file`, other: `${n} files` });

/** Files of this device: opening, building and keeping them. */
export const deviceTexts = part("device", {
  title: "Files of this device",
  drop: "Drop a volume, a store or a scene anywhere",
  /** files, folder: the buttons that choose them. */
  orChoose: <Chooser>(files: Chooser, folder: Chooser) => [", or ", files, " or ", folder, "."],
  chooseFiles: "choose files",
  chooseFolder: "a folder",
  dropText:
    "NRRD, MetaImage, NIfTI, MGH, MRC, NumPy, HDF5, netCDF, DICOM, TIFF, VTK, cube, VASP, XSF, OpenDX, OME-Zarr (a folder) and raw voxels, also in a ZIP, become a store, here in the browser; stores (.isosplat) and scenes (.isobundle) open at once. Nothing is uploaded.",
  dropHere: "Drop a volume or a store: it is read here, nothing is uploaded",
  onDevice: "On this device",
  onDeviceText:
    "Kept by this browser for this site. It may remove them when the disk is full, and a private window loses them when it is closed: save what you need.",
  onDevicePersistent: "Kept by this browser for this site, until you remove them.",
  temporary: "until this tab is closed",
  unreadable: (reason: string) =>
    `Cannot be read: ${reason}. Load the page again, or open its file again.`,
  remainsRemoved: (count: number) =>
    plural(count, {
      one: "A volume was removed: it was not kept completely, because its tab was closed or its removal interrupted.",
      other: `${count} volumes were removed: they were not kept completely, because their tab was closed or their removal interrupted.`,
    }),
  remove: "Remove from this device",
  removeNamed: (name: string) => `Remove ${name} from this device`,
  askRemove: (name: string) => `Remove ${name}? This cannot be undone.`,
  doRemove: "Remove",
  doKeep: "Keep it",

  reading: "Reading",
  files,
  fetching: "Fetching",
  fetchingNamed: (name: string) => `Fetching ${name}`,
  from: (host: string) => `from ${host}`,
  unpacking: (name: string) => `Unpacking ${name}`,
  building: (name: string) => `Building ${name}`,
  otherTab: "waiting: another tab builds the same volume",
  starting: "starting",
  keeping: (name: string) => `Keeping ${name} on this device`,
  untilClosed: "It is open until this tab is closed.",
  preview: (reduced: string, whole: string) => `Preview: ${reduced} of ${whole} voxels`,
  of: (done: string, all: string) => `${done} of ${all}`,
  cancel: "Cancel",
  cancelled: "Cancelled.",
  close: "Close",
  notOpened: "Not opened",
  notKept: "Open, but not kept",
  expectedTitle: (name: string | undefined) =>
    name === undefined
      ? "This volume is not on this device, or not any more: open its file again"
      : `This link shows a view of “${name}”`,
  expectedText:
    "The volume itself is not in the address. Drop or choose the same file here, and its view appears: on this device, nothing is uploaded.",
  otherThanLink: "Open, but not the volume of the link",
  notOfLink: (name: string) =>
    `The link is for another file than “${name}”, or for a store that another version of Isosplat built. Its view is not shown.`,
  oneAtATime:
    "Not opened: what was dropped meanwhile. Drop it again when this is done, or cancel this.",
  fromDevice: "From this device",
  unreachable: (host: string) => `${host} cannot be reached: this is what was kept.`,
  removed: "the store was removed from this device: open its file again",
  cutOff: (host: string) =>
    `Files of this device were read, so this tab makes no requests to other sites: load the page again for more of the volume on ${host}.`,
  noFiles: "no files",
  /** format: that of the name. */
  wrongContent: (path: string, format: string, found: string) =>
    `${path} is not ${format}, as its name says: it contains ${found}. Choose the file of the volume itself.`,
  contents: {
    empty: "nothing",
    webPage: "a web page",
    text: (beginning: string) => `text, which begins with “${beginning}”`,
  },
  nothingFound: (found: string) =>
    `Expected a store (.isosplat) or a volume (NRRD, MetaImage, NIfTI, MGH, MRC, NumPy, HDF5, netCDF, DICOM, TIFF, VTK, cube, VASP, XSF, OpenDX, OME-Zarr or raw), found ${found}.`,

  besideOpen: "A volume is open",
  manners: { add: "Add to the picture", replace: "Open instead" },
  theFiles: "the files themselves",
  whichVolume: (count: number) => `${count} volumes: which one?`,
  /** What is chosen in a file: see VolumeChoice. */
  which: {
    series: "Which series?",
    segment: "Which segment?",
    channel: "Which channel?",
    timeStep: "Which time step?",
    dataset: "Which dataset?",
    allow: "Read it nevertheless?",
  },
  /** Choices by their numbers in the file. */
  numbered: {
    series: (n: string) => `Series ${n}`,
    segment: (n: string) => `Segment ${n}`,
    channel: (n: string) => `Channel ${n}`,
    timeStep: (n: string) => `Time step ${n}`,
  },
  /** Faults that a visitor can accept. */
  allow: {
    gaps: "Read it: missing slices are interpolated",
    truncated: "Read it: missing voxels have no value",
    surplus: "Read it without the extra voxels",
    unplaced: "Read the slices in the order of their numbers",
    frames: "Read times or channels as slices",
  },
  /** What these faults are. */
  faulty: {
    gaps: "Slices are missing, cannot be read, or are unevenly spaced.",
    truncated:
      "The file is incomplete, or its header is wrong. Copy or download it again, if you can.",
    surplus: "The file has more voxels than its header states.",
    unplaced: "The slices do not state their positions. Export them again, if you can.",
    frames: "The file has times or channels of a single slice.",
  },
  whichScale: "Which scale?",
  tooLarge: (count: number) => `(${count} more too large for the browser)`,
  scale: (voxels: string, bytes: string) => `${voxels} voxels · ${bytes} uncompressed`,
  noScale: (name: string, bytes: string) =>
    `${name}: expected voxels whose store the browser has memory to build, found ${bytes}: open a smaller scale`,

  raw: "Raw voxels",
  rawText: (path: string, bytes: string) =>
    `${path}, ${bytes}, has no header. How many voxels does it have, and which?`,
  along: (axis: string) => `Along ${axis}`,
  type: "Type",
  byteOrder: "Byte order",
  littleEndian: "little-endian (usual)",
  bigEndian: "big-endian",
  skip: "Bytes before the voxels",
  sizeFits: "The size fits.",
  build: "Build the store",
  wrongDims: "expected whole numbers of voxels from 2 to 1048576 along each axis",
  wrongSkip: "expected a whole number of bytes to skip, from 0",
  wrongSize: (expected: number, found: number) =>
    `expected ${expected} bytes, found a file of ${found}: correct the size or the type`,

  saveVolume: "Save this volume",
  saveScenePage: "Save this scene as a page",
  keepTitle: "Keep on this device",
  keepText: "Listed on the start page; opens without a network.",
  keepVerb: "Keep",
  saveVerb: "Save",
  store: "Store",
  storeText: "An .isosplat file: for this page, the program isosplat, or any server.",
  singlePage: "Single page",
  singlePageText: "One HTML file with viewer and volume: opens by double click, without a server.",
  scenePageText: "One HTML file with viewer and scene: opens by double click, without a server.",
  webSite: "Web site",
  webSiteText: "A ZIP with page, volume and README: unpack it on any web host.",
  notOpenYet: "the volume is not open yet: try again when it is shown",
  preparing: (title: string) => `${title}: preparing`,
  done: (title: string) => `${title}: done`,

  newVersion: "A new version of this page is ready.",
  reload: "Reload",
  later: "Later",
});
