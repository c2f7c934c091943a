import type { measureTexts as English } from "./measure.ts";
import { plurals } from "./numbers.ts";

const plural = plurals("de");

export const measure: typeof English = {
  kinds: {
    point: "Punkt",
    distance: "Abstand",
    path: "Streckenzug",
    angle: "Winkel",
    note: "Notiz",
  },
  hints: {
    point: "Klicken Sie auf die Fläche.",
    distance: "Klicken Sie auf zwei Punkte der Fläche.",
    path: "Klicken Sie auf die Punkte des Streckenzugs, dann auf Fertig.",
    angle: "Klicken Sie auf drei Punkte: Der zweite ist der Scheitel.",
    note: "Klicken Sie dorthin, wo die Notiz hingehört.",
  },
  keys: "Enter nimmt die Bildmitte, Escape beendet.",
  pathKeys: "Enter nimmt die Bildmitte, Umschalt + Enter ist Fertig, Escape beendet.",
  done: "Fertig",
  end: "Beenden",
  endMeasuring: "Messen beenden",
  missed: "An dieser Stelle ist keine Fläche.",
  tooMany: (measurements, points) =>
    `Es gibt ${measurements} Messungen oder ${points} Punkte: Entfernen Sie zuerst einige.`,
  newNote: (number) => `Notiz ${number}`,

  measure: "Messen",
  measurements: "Messungen",
  noAngle: "kein Winkel",
  coarse: "Aus groben Zellen: Gehen Sie näher heran, um genau zu messen.",
  at: (position) => `bei ${position}`,
  voxel: (voxel) => `Voxel ${voxel}`,
  value: (value) => `Wert ${value}`,
  normal: (normal) => `Normale ${normal}`,
  onLayers: (layers) => `auf ${layers}`,
  ofLevel: (level) => `aus Zellen der Stufe ${level}: Gehen Sie näher heran, um genau zu messen`,
  pointsSet: (n) =>
    n === 0
      ? "Kein Punkt gesetzt"
      : plural(n, { one: `${n} Punkt gesetzt`, other: `${n} Punkte gesetzt` }),
  count: (n) =>
    n === 0 ? "Keine Messungen" : plural(n, { one: `${n} Messung`, other: `${n} Messungen` }),
  isRemoved: (name) => `${name} entfernt`,
  again: "Neu",
  againNamed: (name) => `${name} neu messen`,
  againTitle: "Misst neu und behält den Text. Punkte im Bild lassen sich auch ziehen.",
  remove: "Entfernen",
  removeNamed: (name) => `${name} entfernen`,
  text: "Text",
  textOf: (name) => `Text von ${name}`,
  extentTitle:
    "Der ganzen Isofläche, aus Dreiecken in voller Auflösung, für die diese Bytes gelesen werden",
  extent: "Flächeninhalt und Volumen",
  stop: "Anhalten",
  isovalue: (isovalue) => `Isowert ${isovalue}`,
  area: "Flächeninhalt",
  volume: "Volumen größerer Werte",
  holes: "kein Volumen: Die Fläche hat Löcher, wo Voxel fehlen",

  copyAndSave: "Kopieren und speichern",
  copy: "Kopieren",
  removeAll: "Alle entfernen",
  saveSession: "Sitzung speichern",
  saveSessionTitle:
    "Ansicht und Messungen in einer Datei: Ziehen Sie sie auf diese Seite, um sie zu öffnen",
  copied: "Messungen kopiert",
  noClipboard:
    "Der Browser erlaubt keinen Zugriff auf die Zwischenablage: Speichern Sie die Messungen stattdessen",
  ignored: (count, all) =>
    `${count} von ${all} Messungen in der Adresse wurden nicht beachtet: Erwartet wird kind,x,y,z.`,
  otherVersion:
    "Die Messungen gehören zu einer anderen Fassung dieses Volumens: Seine Flächen können woanders liegen.",
  isDistorted: "nicht gemessen: die Ebene ist gestreckt oder geschert",
  notInAddress:
    "Die Messungen und Ebenen passen nicht in die Adresse: Links haben weniger. Speichern Sie eine Sitzung, um sie weiterzugeben.",
};
