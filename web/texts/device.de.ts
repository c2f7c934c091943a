import type { deviceTexts as English } from "./device.ts";
import { plurals } from "./numbers.ts";

const plural = plurals("de");

export const device: typeof English = {
  title: "Dateien dieses Geräts",
  drop: "Ein Volumen, eine Isosplat-Datei oder eine Szene irgendwohin ziehen",
  orChoose: (files, folder) => [" oder ", files, " oder ", folder, "."],
  chooseFiles: "Dateien auswählen",
  chooseFolder: "einen Ordner",
  dropText:
    "NRRD, MetaImage, NIfTI, MGH, MRC, NumPy, HDF5, netCDF, DICOM, TIFF, VTK, cube, VASP, XSF, OpenDX, OME-Zarr (ein Ordner) und rohe Voxel, auch in einem ZIP, werden hier im Browser zu einer Isosplat-Datei; Isosplat-Dateien (.isosplat) und Szenen (.isobundle) öffnen sich sofort. Nichts wird hochgeladen.",
  dropHere: "Volumen oder Isosplat-Datei hier ablegen: Gelesen wird hier, nichts wird hochgeladen",
  onDevice: "Auf diesem Gerät",
  onDeviceText:
    "Von diesem Browser für diese Website aufbewahrt. Er kann sie entfernen, wenn der Datenträger voll ist, und ein privates Fenster verliert sie, wenn es geschlossen wird: Speichern Sie, was Sie brauchen.",
  onDevicePersistent: "Von diesem Browser für diese Website aufbewahrt, bis Sie sie entfernen.",
  temporary: "bis dieser Tab geschlossen wird",
  unreadable: (reason) =>
    `Kann nicht gelesen werden: ${reason}. Laden Sie die Seite neu, oder öffnen Sie die Datei noch einmal.`,
  remainsRemoved: (count) =>
    plural(count, {
      one: "Ein Volumen wurde entfernt: Es war nicht vollständig aufbewahrt, weil der Tab geschlossen oder das Entfernen unterbrochen wurde.",
      other: `${count} Volumen wurden entfernt: Sie waren nicht vollständig aufbewahrt, weil der Tab geschlossen oder das Entfernen unterbrochen wurde.`,
    }),
  remove: "Von diesem Gerät entfernen",
  removeNamed: (name) => `${name} von diesem Gerät entfernen`,
  askRemove: (name) => `${name} entfernen? Das lässt sich nicht rückgängig machen.`,
  doRemove: "Entfernen",
  doKeep: "Behalten",

  reading: "Wird gelesen",
  files: (n) => plural(n, { one: `${n} Datei`, other: `${n} Dateien` }),
  fetching: "Wird geladen",
  fetchingNamed: (name) => `${name} wird geladen`,
  from: (host) => `von ${host}`,
  unpacking: (name) => `${name} wird entpackt`,
  building: (name) => `${name} wird umgewandelt`,
  otherTab: "wartet: Ein anderer Tab wandelt dasselbe Volumen um",
  starting: "beginnt",
  keeping: (name) => `${name} wird auf diesem Gerät aufbewahrt`,
  untilClosed: "Es ist geöffnet, bis dieser Tab geschlossen wird.",
  preview: (reduced, whole) => `Vorschau: ${reduced} von ${whole} Voxeln`,
  of: (done, all) => `${done} von ${all}`,
  cancel: "Abbrechen",
  cancelled: "Abgebrochen.",
  close: "Schließen",
  notKept: "Geöffnet, aber nicht aufbewahrt",
  oneAtATime:
    "Nicht geöffnet: was inzwischen abgelegt wurde. Legen Sie es noch einmal ab, wenn dies fertig ist, oder brechen Sie dies ab.",
  notOpened: "Nicht geöffnet",
  expectedTitle: (name) =>
    name === undefined
      ? "Dieses Volumen ist nicht oder nicht mehr auf diesem Gerät: Öffnen Sie seine Datei noch einmal"
      : `Dieser Link zeigt eine Ansicht von „${name}“`,
  expectedText:
    "Das Volumen selbst ist nicht in der Adresse. Legen Sie dieselbe Datei hier ab, oder wählen Sie sie: Dann erscheint die Ansicht. Alles bleibt auf diesem Gerät, nichts wird hochgeladen.",
  otherThanLink: "Geöffnet, aber nicht das Volumen des Links",
  notOfLink: (name) =>
    `Der Link gehört zu einer anderen Datei als „${name}“, oder zu einer, die eine andere Version von Isosplat umgewandelt hat. Seine Ansicht wird nicht gezeigt.`,
  fromDevice: "Von diesem Gerät",
  unreachable: (host) => `${host} ist nicht erreichbar: Dies wurde aufbewahrt.`,
  removed: "Die Isosplat-Datei wurde von diesem Gerät entfernt: Öffnen Sie ihr Volumen noch einmal",
  cutOff: (host) =>
    `Es wurden Dateien dieses Geräts gelesen, darum stellt dieser Tab keine Anfragen an andere Sites: Laden Sie die Seite neu, um mehr vom Volumen auf ${host} zu sehen.`,
  wrongContent: (path, format, found) =>
    `${path} ist kein ${format}, wie der Name sagt, sondern enthält ${found}. Wählen Sie die Datei des Volumens selbst.`,
  contents: {
    empty: "nichts",
    webPage: "eine Webseite",
    text: (beginning) => `Text, der mit „${beginning}“ beginnt`,
  },
  noFiles: "keine Dateien",
  nothingFound: (found) =>
    `Erwartet wird eine Isosplat-Datei (.isosplat) oder ein Volumen (NRRD, MetaImage, NIfTI, MGH, MRC, NumPy, HDF5, netCDF, DICOM, TIFF, VTK, cube, VASP, XSF, OpenDX, OME-Zarr oder roh), gefunden: ${found}.`,

  besideOpen: "Ein Volumen ist offen",
  manners: { add: "Zum Bild hinzufügen", replace: "Stattdessen öffnen" },
  theFiles: "die Dateien selbst",
  whichVolume: (count) => `${count} Volumen: welches?`,
  which: {
    series: "Welche Serie?",
    segment: "Welches Segment?",
    channel: "Welcher Kanal?",
    timeStep: "Welcher Zeitschritt?",
    dataset: "Welcher Datensatz?",
    allow: "Trotzdem lesen?",
  },
  numbered: {
    series: (n) => `Serie ${n}`,
    segment: (n) => `Segment ${n}`,
    channel: (n) => `Kanal ${n}`,
    timeStep: (n) => `Zeitschritt ${n}`,
  },
  allow: {
    gaps: "Lesen: Fehlende Schichten werden interpoliert",
    truncated: "Lesen: Fehlende Voxel haben keinen Wert",
    surplus: "Ohne die überzähligen Voxel lesen",
    unplaced: "Die Schichten in der Reihenfolge ihrer Nummern lesen",
    frames: "Zeiten oder Kanäle als Schichten lesen",
  },
  faulty: {
    gaps: "Schichten fehlen, sind nicht lesbar oder haben ungleiche Abstände.",
    truncated:
      "Die Datei ist unvollständig, oder ihr Kopf ist falsch. Kopieren oder laden Sie sie noch einmal, wenn Sie können.",
    surplus: "Die Datei hat mehr Voxel, als ihr Kopf angibt.",
    unplaced:
      "Die Schichten geben ihre Lage nicht an. Exportieren Sie sie noch einmal, wenn Sie können.",
    frames: "Die Datei hat Zeiten oder Kanäle einer einzigen Schicht.",
  },
  whichScale: "Welche Auflösung?",
  tooLarge: (count) => `(${count} weitere zu groß für den Browser)`,
  scale: (voxels, bytes) => `${voxels} Voxel · ${bytes} unkomprimiert`,
  noScale: (name, bytes) =>
    `${name}: Erwartet werden Voxel, die der Browser in seinem Speicher umwandeln kann, gefunden ${bytes}: Öffnen Sie eine kleinere Auflösung`,

  raw: "Rohe Voxel",
  rawText: (path, bytes) =>
    `${path}, ${bytes}, hat keinen Kopf. Wie viele Voxel enthält die Datei, und welche?`,
  along: (axis) => `Entlang ${axis}`,
  type: "Typ",
  byteOrder: "Bytereihenfolge",
  littleEndian: "Little-Endian (üblich)",
  bigEndian: "Big-Endian",
  skip: "Bytes vor den Voxeln",
  sizeFits: "Die Größe passt.",
  build: "Umwandeln",
  wrongDims: "Erwartet werden ganze Zahlen von 2 bis 1048576 Voxeln entlang jeder Achse",
  wrongSkip: "Erwartet wird eine ganze Zahl von Bytes, ab 0",
  wrongSize: (expected, found) =>
    `Erwartet werden ${expected} Bytes, die Datei hat ${found}: Berichtigen Sie die Größe oder den Typ`,

  saveVolume: "Dieses Volumen speichern",
  saveScenePage: "Diese Szene als Seite speichern",
  keepTitle: "Auf diesem Gerät aufbewahren",
  keepText: "Steht auf der Startseite; öffnet sich ohne Netz.",
  keepVerb: "Aufbewahren",
  saveVerb: "Speichern",
  store: "Isosplat-Datei",
  storeText: "Eine .isosplat-Datei: für diese Seite, das Programm isosplat oder jeden Server.",
  singlePage: "Einzelne Seite",
  singlePageText:
    "Eine HTML-Datei mit Betrachter und Volumen: öffnet sich per Doppelklick, ohne Server.",
  scenePageText:
    "Eine HTML-Datei mit Betrachter und Szene: öffnet sich per Doppelklick, ohne Server.",
  webSite: "Website",
  webSiteText: "Ein ZIP mit Seite, Volumen und README: auf jedem Webserver zu entpacken.",
  notOpenYet: "Das Volumen ist noch nicht geöffnet: Versuchen Sie es, wenn es zu sehen ist",
  preparing: (title) => `${title}: wird vorbereitet`,
  done: (title) => `${title}: fertig`,

  newVersion: "Eine neue Fassung dieser Seite liegt bereit.",
  reload: "Neu laden",
  later: "Später",
};
