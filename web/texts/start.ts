import { plurals } from "./numbers.ts";
import { part } from "./part.ts";

const plural = plurals("en");
const volumes = (n: number) => plural(n, { one: `${n} volume`, other: `${n} volumes` });
const scenes = (n: number) => plural(n, { one: `${n} scene`, other: `${n} scenes` });

/** The start page. */
export const startTexts = part("start", {
  theList: "the list of volumes",
  needsToken: "This server needs a token",
  needsTokenText:
    "Open the complete address that the server printed, or the link that you received.",
  noList: "No list of volumes",
  noListText: "This host has no list of volumes. Open a store by its address below.",
  noAnswer: "The server does not answer.",
  notAdmitted: "The server does not admit this page.",
  listStatus: (status: number) => `The server returned status ${status} for the list of volumes.`,
  notAList: "The server's list of volumes cannot be read: is it an Isosplat server?",
  volumes: "Volumes",
  noScene: "No such scene",
  noSceneText: (name: string) =>
    `There is no scene “${name}”. It may have been renamed or removed. If it comes back, the page opens it automatically.`,
  scenes: "Scenes",
  scenesAndVolumes: "Scenes and volumes",
  sceneCount: scenes,
  layers: (count: number) => plural(count, { one: `${count} layer`, other: `${count} layers` }),
  steps: (count: number) => plural(count, { one: `${count} step`, other: `${count} steps` }),
  lead: "Streams isosurfaces of large volumes, only as much as the view needs.",
  count: volumes,
  onServer: (count: number, bytes: string) => `${volumes(count)}, ${bytes} on the server`,
  search: "Search",
  searchLabel: "Search volumes and scenes by name or title",
  keptList: (time: string) =>
    `Without a connection: this is the list of ${time}. The parts of a volume that were fetched before can be shown; volumes on this device open as usual.`,
  /** command: the command that builds a store. */
  noVolumes: <Command>(command: Command) => [
    "This server has no volumes yet. Make a store with ",
    command,
    " and put it into the folder that is served.",
  ],
  noMatch: (query: string) => `Nothing has “${query}” in its name or title.`,
  matches: (found: string, query: string) => `${found} with “${query}”`,
  showMore: "Show more",
  notShown: (left: number, total: number) => `${left} of ${total} are not shown`,
  voxels: (count: string) => `${count} voxels`,
  loading: "Loading the volumes",
  elsewhere: "Open a store or a volume from elsewhere",
  elsewhereText:
    "The address of a store (.isosplat), of a volume’s file (.nii.gz, .nrrd, …) or of OME-Zarr on any host that allows other sites to read it (CORS). Of a store, the page fetches only parts (HTTP Range). It fetches a volume as a whole, and builds a store from it here in the browser.",
  address: "Address of a store or a volume",
  open: "Open",
  badAddress: (address: string, example: string) =>
    `src=${address}: expected the http or https address of a store, such as ${example}; correct it in the address bar`,
});
