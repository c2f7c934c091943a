import { plurals } from "./numbers.ts";
import type { startTexts as English } from "./start.ts";

const plural = plurals("de");
const volumes = (n: number) => plural(n, { one: `${n} Volumen`, other: `${n} Volumen` });
const scenes = (n: number) => plural(n, { one: `${n} Szene`, other: `${n} Szenen` });

export const start: typeof English = {
  theList: "die Liste der Volumen",
  needsToken: "Dieser Server verlangt ein Token",
  needsTokenText:
    "Öffnen Sie die ganze Adresse, die der Server ausgegeben hat, oder den Link, den Sie bekommen haben.",
  noList: "Keine Liste von Volumen",
  noListText:
    "Dieser Host hat keine Liste von Volumen. Öffnen Sie unten eine Isosplat-Datei über ihre Adresse.",
  noAnswer: "Der Server antwortet nicht.",
  notAdmitted: "Der Server lässt diese Seite nicht zu.",
  listStatus: (status) =>
    `Der Server hat auf die Frage nach der Liste der Volumen mit Status ${status} geantwortet.`,
  notAList: "Die Liste der Volumen ist nicht lesbar: Ist das ein Isosplat-Server?",
  volumes: "Volumen",
  noScene: "Diese Szene gibt es nicht",
  noSceneText: (name) =>
    `Es gibt keine Szene „${name}“. Vielleicht wurde sie umbenannt oder entfernt. Kommt sie wieder, wird sie von selbst geöffnet.`,
  scenes: "Szenen",
  scenesAndVolumes: "Szenen und Volumen",
  sceneCount: scenes,
  layers: (count) => plural(count, { one: `${count} Ebene`, other: `${count} Ebenen` }),
  steps: (count) => plural(count, { one: `${count} Schritt`, other: `${count} Schritte` }),
  lead: "Zeigt Isoflächen großer Volumen und lädt nur, was die Ansicht braucht.",
  count: volumes,
  onServer: (count, bytes) => `${volumes(count)}, ${bytes} auf dem Server`,
  search: "Suchen",
  searchLabel: "Volumen und Szenen nach Name oder Titel durchsuchen",
  keptList: (time) =>
    `Ohne Verbindung: Dies ist die Liste vom ${time}. Die Teile eines Volumens, die schon geladen wurden, können gezeigt werden; Volumen auf diesem Gerät öffnen sich wie immer.`,
  noVolumes: (command) => [
    "Dieser Server hat noch keine Volumen. Erzeugen Sie eine Isosplat-Datei mit ",
    command,
    " und legen Sie sie in den Ordner, den der Server ausliefert.",
  ],
  noMatch: (query) => `Nichts hat „${query}“ im Namen oder Titel.`,
  matches: (found, query) => `${found} mit „${query}“`,
  showMore: "Mehr anzeigen",
  notShown: (left, total) => `${left} von ${total} werden nicht angezeigt`,
  voxels: (count) => `${count} Voxel`,
  loading: "Die Volumen werden geladen",
  elsewhere: "Eine Isosplat-Datei oder ein Volumen von anderswo öffnen",
  elsewhereText:
    "Die Adresse einer Isosplat-Datei (.isosplat), der Datei eines Volumens (.nii.gz, .nrrd, …) oder von OME-Zarr auf einem Host, der anderen Seiten das Lesen erlaubt (CORS). Von einer Isosplat-Datei werden Teile geladen (HTTP Range); ein Volumen wird ganz geladen und hier im Browser umgewandelt.",
  address: "Adresse einer Isosplat-Datei oder eines Volumens",
  open: "Öffnen",
  badAddress: (address, example) =>
    `src=${address}: Erwartet wird die http- oder https-Adresse einer Isosplat-Datei, wie ${example}; berichtigen Sie sie in der Adresszeile`,
};
