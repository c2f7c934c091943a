import type { captureTexts as English } from "./capture.ts";
import { plurals } from "./numbers.ts";

const plural = plurals("de");

export const capture: typeof English = {
  title: "Bilder und Filme",
  what: "Was",
  whats: {
    picture: "Bild",
    turntable: "Film: einmal herum",
    sweep: "Film: durch Isowerte",
    path: "Film: von Ansicht zu Ansicht",
    time: "Film: durch die Zeit",
  },
  from: "Von Isowert",
  to: "Bis Isowert",
  views: (n) => plural(n, { one: `${n} Ansicht`, other: `${n} Ansichten` }),
  addView: "Diese Ansicht hinzufügen",
  removeAll: "Alle entfernen",
  size: "Größe in Pixeln",
  asShown: "Wie gezeigt",
  timesShown: (times) => `${times} × wie gezeigt`,
  otherSize: "Andere …",
  width: "Breite",
  height: "Höhe",
  seconds: "Sekunden",
  framesPerSecond: "Bilder je Sekunde",
  file: "Datei",
  mp4: "MP4-Video (H.264)",
  webm: "WebM-Video",
  gif: "Animiertes GIF",
  pngs: "PNG-Dateien in einem ZIP",
  svg: "SVG: das Bild, darüber Linien und Buchstaben",
  marks: "Über dem Bild",
  markNames: {
    title: "Titel",
    scale: "Maßstab",
    axes: "Achsen",
    legend: "Legende",
    measurements: "Messungen",
  },
  transparent: "Ohne Hintergrund (durchsichtig)",
  frames: (n) => `${n} Bilder`,
  atMost: (frames, bytes) => `${frames}, höchstens etwa ${bytes}`,
  save: "Speichern",
  cancel: "Abbrechen",
  cancelled: "Abgebrochen",
  saving: "Wird gespeichert",
  preparing: "Wird vorbereitet",
  fetching: (bytes) => `Wird geladen: noch ${bytes}`,
  drawing: (percent) => `Wird gezeichnet: ${percent} %`,
  saved: (bytes) => `Gespeichert: ${bytes}.`,
  noPicture: "Es gibt noch kein Bild",
  limited:
    "Teile sind gröber, als diese Größe zeigen könnte: Die Grenze des Arbeitsspeichers ist erreicht.",
  notFetched:
    "Teile sind gröber, als diese Größe zeigen könnte: Ihre Daten konnten nicht geladen werden.",
  noVideo: (width, height) =>
    `Dieser Browser kodiert kein Video von ${width} × ${height} Pixeln: Wählen Sie eine kleinere Größe oder PNG-Dateien`,
  wrongSize: (most) => `Breite und Höhe: ganze Zahlen von 1 bis ${most}.`,
  wrongSeconds: (most, framesPerSecond) =>
    `Sekunden: höchstens ${most} bei ${framesPerSecond} Bildern je Sekunde.`,
  wrongIsovalues: "Die Isowerte von und bis: Zahlen.",
  tooFewViews:
    "Fügen Sie mindestens zwei Ansichten hinzu: Schließen Sie diesen Dialog, bewegen Sie die Ansicht, und kommen Sie zurück.",
};
