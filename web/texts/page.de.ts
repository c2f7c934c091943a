import { plurals } from "./numbers.ts";
import type { pageTexts as English } from "./page.ts";

const plural = plurals("de");

export const page: typeof English = {
  home: "Isosplat: alle Volumen",
  lightTheme: "Helle Darstellung",
  darkTheme: "Dunkle Darstellung",
  language: "Sprache",
  onThisServer: "Volumen auf diesem Server",
  again: "Erneut versuchen",
  loadAnew: "Seite neu laden",
  allVolumes: "Alle Volumen",
  details: "Einzelheiten",
  incomplete:
    "Ein Teil dieser Seite wurde nicht geladen: Die Verbindung ist abgebrochen, oder die Seite wurde auf ihrem Server erneuert. Er wird noch einmal angefordert.",
  reload: "Neu laden",
  dismiss: "Schließen",

  reset: "Ansicht zurücksetzen",
  savePicture: "Bild speichern",
  copyLink: "Link zu dieser Ansicht kopieren",
  shareLink: "Link zu dieser Ansicht teilen",
  keys: "Tasten und Gesten",
  controls: "Bedienfeld",
  fewer: "Weniger Bedienelemente",
  more: "Mehr Bedienelemente",
  view3d: "3D-Ansicht",
  picture: (volume, isovalues) =>
    `Isofläche von ${volume} bei ${isovalues}. Pfeiltasten drehen sie, Plus und Minus vergrößern und verkleinern.`,

  voxels: (text, voxels) => `${text} ${plural(voxels, { one: "Voxel", other: "Voxel" })}`,
  nothingThere: "In der Mitte des Bildes ist keine Ebene mit einem Namen.",
  linkCopied: "Link kopiert",
  linkNeedsFile: (names: string) =>
    `Er enthält die Ansicht, nicht das Volumen, das nur auf diesem Gerät liegt: Wer ihn öffnet, braucht dieselbe Datei („${names}“).`,
  linkOfThisComputer:
    "Er gilt nur auf diesem Rechner: Andere Rechner erreichen die Adresse des Servers nicht.",
  noLinkOfFile:
    "Eine Seite, die aus einer Datei geöffnet wurde, hat keinen Link für andere. Senden Sie die Datei selbst.",
  noLinkOfScene:
    "Eine Szene, die von diesem Gerät geöffnet wurde, hat keinen Link. Senden Sie ihre Datei, oder speichern Sie sie als einzelne Seite.",
  noSharing: "Das System dieses Geräts hat den Link nicht angenommen: Sie können ihn kopieren",
  noClipboard:
    "Der Browser erlaubt keinen Zugriff auf die Zwischenablage: Kopieren Sie die Adresszeile",
  pictureSaved: "Bild gespeichert",
  noPicture: "Es gibt noch kein Bild",
  replaced: "Das Volumen wurde auf seinem Server ersetzt: Dies ist die neue Fassung.",
  layerMissing: (name, reason) => `Die Ebene ${name} kann nicht gezeigt werden: ${reason}.`,
  allHidden: (name) =>
    `${name}: Alle Ebenen der Szene sind ausgeblendet. Blenden Sie im Dokument der Szene eine ein.`,
  viewTooFar:
    "Die Ansicht in der Adresse ist zu weit vom Volumen entfernt: Gezeigt wird die Anfangsansicht.",
  isovaluesOutside: (isovalues, low, high) =>
    `Die Adresse enthält den Isowert ${isovalues}, aber die Werte des Volumens sind ${low} bis ${high}.`,
  noHandles:
    "Die Griffe des Schnittquaders konnten nicht geladen werden: Die Verbindung ist abgebrochen. Öffnen Sie den Abschnitt noch einmal.",
  noSection:
    "Der Abschnitt konnte nicht geladen werden: Die Verbindung ist abgebrochen. Öffnen Sie ihn noch einmal.",
  noMeasuring:
    "Das Messen konnte nicht geladen werden: Die Verbindung ist abgebrochen. Versuchen Sie es erneut.",
  savedUnmoved:
    "Die Fläche wird in den Koordinaten ihres Volumens gespeichert: Die Ebene wird an anderer Stelle gezeigt.",
  noSaving:
    "Das Speichern konnte nicht geladen werden: Die Verbindung ist abgebrochen. Versuchen Sie es erneut.",
  spacingUnchanged:
    "Das Volumen konnte nicht mit anderen Voxelabständen geöffnet werden: Nichts wurde geändert.",
  noDialog:
    "Der Dialog konnte nicht geladen werden: Die Verbindung ist abgebrochen. Versuchen Sie es erneut.",

  ignored: (setting, expected) =>
    `„${setting}“ in der Adresse wurde nicht beachtet: Erwartet wird ${expected}.`,
  invisible: (percent) =>
    `Die Adresse enthält eine unsichtbare Fläche: Sie wird mit ${percent} % gezeigt.`,
  isSpacing: "drei Zahlen über 0, in mm",
  isNumbers: "Zahlen wie 60.5,180",
  isNumber: "eine Zahl",
  isAboveZero: "eine Zahl über 0",
  isColours: "Farben wie d9ccb3",
  isColour: "eine Farbe wie ffffff",
  linesEvery: (interval) => `Linien alle ${interval}`,
  linesPerDecades: (count, isOne) =>
    isOne ? "Linien jede Dekade" : `Linien alle ${count} Dekaden`,
  logarithmic: (quantity) => `${quantity}, logarithmisch`,
  noFieldValue: (field) => `${field}: kein Wert`,
  isFieldName: "der Name eines Feldes",
  isShares: "Zahlen von 0 bis 1",
  isShare: "eine Zahl von 0 bis 1",
  isBox: "x0,x1,y0,y1,z0,z1, je von 0 bis 1",
  isParts: (parts) => `none oder einige von ${parts}`,
  isEither: (one, other) => `${one} oder ${other}`,
  isInRanges: (ranges) => `Zahlen: ${ranges}`,

  status: "Zustand",
  samplesTitle: "Im letzten Bild gezeichnete Punkte",
  samples: (count) => `${count} Punkte`,
  bytesTitle: "Seit dem Öffnen des Volumens geladene Daten",
  fetched: (bytes) => `${bytes} geladen`,
  levelTitle: "Gezeigte Detailstufe; 0 ist das Volumen selbst",
  fullResolution: "volle Auflösung",
  level: (level) => `Stufe ${level}`,
  levels: (finest, coarsest) => `Stufen ${finest}–${coarsest}`,
  framesTitle: "Bilder je Sekunde, während sich die Ansicht bewegt",
  frames: (perSecond) => `${perSecond} Bilder/s`,
  stateTitle: "Was für diese Ansicht noch zu laden ist",
  toGo: (bytes) => `noch ${bytes}`,
  complete: "vollständig",
  quick: "schnelles Bild",
  quickTitle:
    "Dieses Gerät zeichnet langsam: glatte Kanten und Schatten fehlen, außer in gespeicherten Bildern",
  noSurface: "vollständig: keine Fläche in dieser Ansicht",
  clipped: "vollständig: ein Teil ist abgeschnitten",
  noSurfaceLeft: "vollständig: keine Fläche in dieser Ansicht, in der ein Teil abgeschnitten ist",
  limited: "durch den Arbeitsspeicher begrenzt",
  opening: "wird geöffnet",
  serverError: "Serverfehler, neuer Versuch",
  offline: "keine Verbindung, neuer Versuch",
  refining: "wird feiner",
  missing: "Teile fehlen",
  damaged: (n) =>
    `vollständig bis auf ${plural(n, { one: `${n} beschädigten Teil`, other: `${n} beschädigte Teile` })}`,
  preparing: (bytes, planned) => `bereitet andere Isowerte vor, ${bytes} von ${planned}`,

  near: "nah",
  far: "fern",
  left: (time) => `noch ${time}`,
  perLength: (units) => `${units ? `${units} ` : ""}je Längeneinheit`,
  cells: "Zellen",
  colours: (name, low, high, units) => `Farben: ${name}, ${low} bis ${high} ${units}`,
  histogram: "Histogramm der Werte des Volumens und die aktiven Zellen jedes Isowerts",
  to: (low, high) => `${low} bis ${high}`,
  notPerpendicular: (degrees) => `nicht senkrecht: ${degrees}° Abweichung`,
  bits: (bits) => `${bits} Bit`,
  signed: (bits) => `${bits} Bit mit Vorzeichen`,
  float: (bits) => `${bits} Bit Gleitkomma`,
};
