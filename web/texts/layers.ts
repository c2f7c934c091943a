import { plurals } from "./numbers.ts";
import { part } from "./part.ts";

const plural = plurals("en");

/** The list of layers. */
export const layersTexts = part("layers", {
  list: "Layers",
  search: "Search",
  searchLabel: "Search the layers",
  noMatch: "No layer matches.",
  all: "Show all",
  none: "Hide all",
  add: "Add a volume …",
  addTitle: "Add a volume",
  save: "Save the scene",
  saveTitle:
    "Saves a file with the addresses of the layers, their surfaces and places, time, camera, clipping, slices, look and measurements. It contains no volumes.",
  saved: (file: string) => `${file} was saved. Open it with this page.`,
  savedWithout: (file: string, layers: string, count: number) =>
    plural(count, {
      one: `${file} was saved without ${layers}: this layer is from a file of this device, and has no address.`,
      other: `${file} was saved without ${layers}: these layers are from files of this device, and have no addresses.`,
    }),
  notSaved:
    "No scene was saved: all layers are from files of this device, and have no addresses. Put the files on a server or a web host first.",
  ofServer: "A volume or a scene of this server",
  noVolume: "No volume or scene of this server matches.",
  moreVolumes: (volumes: number) => `${volumes} more: search for them.`,
  sceneOf: (layers: number) =>
    plural(layers, { one: `scene of ${layers} layer`, other: `scene of ${layers} layers` }),
  steps: (steps: number) => plural(steps, { one: `${steps} step`, other: `${steps} steps` }),
  changesWithTime: (scene: string) =>
    `${scene} changes with time, so its layers are not added to another picture: open it by itself.`,
  address: "A store or a scene at an address",
  addAddress: "Add",
  files: "Choose files of this device …",
  show: (layer: string) => `Show ${layer}`,
  showGroup: (group: string) => `Show the group ${group}`,
  group: (group: string, layers: number) =>
    `${group}, ${layers} ${plural(layers, { one: "layer", other: "layers" })}`,
  colourOf: (layer: string) => `Colour of ${layer}`,
  opacityOf: (layer: string) => `Opacity of ${layer}`,
  choose: "Choose this layer: isovalue and surfaces act on it",
  move: "Drag to move the layer in the list",
  keys: "Arrow keys: another layer. Alt and arrow keys: move. F2: rename. Delete: remove.",
  nameOf: (layer: string) => `Name of ${layer}`,
  chosen: "The chosen layer",
  solo: "Show only this",
  soloTitle: "Hide all other layers; again: show them as before",
  rename: "Rename",
  up: "Up",
  upTitle: "Move the layer up in the list (Alt+↑)",
  down: "Down",
  downTitle: "Move the layer down in the list (Alt+↓)",
  remove: "Remove",
  removeTitle: "Remove the layer from the picture (Delete)",
  firstStays: "The page's own volume can be hidden, but not removed",
  groupField: "Group",
  moved: (layer: string, position: number, of: number) => `${layer}: ${position} of ${of}`,
  removed: (layer: string) => `${layer} was removed. Undo: Ctrl+Z.`,
  added: (layer: string) => `${layer} was added.`,
  opening: "being opened",
  notOpened: (layer: string, reason: string) => `${layer} could not be opened. ${reason}`,
  notHere: "It is not kept on this device: open its file again.",
  cutOff: (host: string) =>
    `Files of this device were read, so this tab makes no requests to ${host}: load the page again.`,
  notAStore:
    "Its address is that of a volume, not of a store: open the volume to build a store of it.",
  unplaced: (layers: string, count: number) =>
    plural(count, {
      one: `${layers}: its file does not say where it lies. It is shown with its first voxel at the origin of the world.`,
      other: `${layers}: their files do not say where they lie. They are shown with their first voxels at the origin of the world.`,
    }),
  apart: (layers: string, first: string, count: number) =>
    plural(count, {
      one: `${layers} lies apart from ${first}: their frames of reference contradict each other, or they show different places.`,
      other: `${layers} lie apart from ${first}: their frames of reference contradict each other, or they show different places.`,
    }),
  otherFrame: (layers: string, first: string, count: number) =>
    plural(count, {
      one: `${layers} and ${first} have different frames of reference: their relative position in the picture means nothing.`,
      other: `${layers} have other frames of reference than ${first}: their relative position in the picture means nothing.`,
    }),
  andMore: (layers: string, left: number) => `${layers} and ${left} more`,
  unknownLayers: (layers: number) =>
    layers === 1
      ? "1 layer of the address does not exist."
      : `${layers} layers of the address do not exist.`,
});
