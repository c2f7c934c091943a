import type { layersTexts } from "./layers.ts";
import { plurals } from "./numbers.ts";

const plural = plurals("de");

export const layers: typeof layersTexts = {
  list: "Ebenen",
  search: "Suchen",
  searchLabel: "Ebenen suchen",
  noMatch: "Keine Ebene passt.",
  all: "Alle zeigen",
  none: "Alle verbergen",
  add: "Volumen hinzufügen …",
  addTitle: "Volumen hinzufügen",
  save: "Szene speichern",
  saveTitle:
    "Speichert eine Datei mit den Adressen der Ebenen, ihren Flächen und ihrer Lage, Zeit, Kamera, Schnitten, Schichten, Darstellung und Messungen. Sie enthält keine Volumen.",
  saved: (file) => `${file} wurde gespeichert. Öffnen Sie die Datei mit dieser Seite.`,
  savedWithout: (file, layers, count) =>
    plural(count, {
      one: `${file} wurde ohne ${layers} gespeichert: Diese Ebene ist aus einer Datei dieses Geräts und hat keine Adresse.`,
      other: `${file} wurde ohne ${layers} gespeichert: Diese Ebenen sind aus Dateien dieses Geräts und haben keine Adressen.`,
    }),
  notSaved:
    "Es wurde keine Szene gespeichert: Alle Ebenen sind aus Dateien dieses Geräts und haben keine Adressen. Legen Sie die Dateien zuerst auf einen Server oder Webspace.",
  ofServer: "Ein Volumen oder eine Szene dieses Servers",
  noVolume: "Kein Volumen und keine Szene dieses Servers passt.",
  moreVolumes: (volumes) => `${volumes} weitere: Suchen Sie danach.`,
  sceneOf: (layers) =>
    plural(layers, { one: `Szene mit ${layers} Ebene`, other: `Szene mit ${layers} Ebenen` }),
  steps: (steps) => plural(steps, { one: `${steps} Schritt`, other: `${steps} Schritte` }),
  changesWithTime: (scene) =>
    `${scene} ändert sich mit der Zeit, deshalb werden ihre Ebenen keinem anderen Bild hinzugefügt: Öffnen Sie die Szene für sich.`,
  address: "Eine Isosplat-Datei oder eine Szene an einer Adresse",
  addAddress: "Hinzufügen",
  files: "Dateien von diesem Gerät wählen …",
  show: (layer) => `${layer} zeigen`,
  showGroup: (group) => `Gruppe ${group} zeigen`,
  group: (group, layers) =>
    `${group}, ${layers} ${plural(layers, { one: "Ebene", other: "Ebenen" })}`,
  colourOf: (layer) => `Farbe von ${layer}`,
  opacityOf: (layer) => `Deckkraft von ${layer}`,
  choose: "Diese Ebene wählen: Isowert und Flächen gelten für sie",
  move: "Ziehen, um die Ebene in der Liste zu verschieben",
  keys: "Pfeiltasten: andere Ebene. Alt und Pfeiltasten: verschieben. F2: umbenennen. Entf: entfernen.",
  nameOf: (layer) => `Name von ${layer}`,
  chosen: "Die gewählte Ebene",
  solo: "Nur diese zeigen",
  soloTitle: "Alle anderen Ebenen verbergen; noch einmal: sie zeigen wie zuvor",
  rename: "Umbenennen",
  up: "Nach oben",
  upTitle: "Ebene in der Liste nach oben verschieben (Alt+↑)",
  down: "Nach unten",
  downTitle: "Ebene in der Liste nach unten verschieben (Alt+↓)",
  remove: "Entfernen",
  removeTitle: "Ebene aus dem Bild entfernen (Entf)",
  firstStays: "Das Volumen der Seite kann verborgen, aber nicht entfernt werden",
  groupField: "Gruppe",
  moved: (layer, position, of) => `${layer}: ${position} von ${of}`,
  removed: (layer) => `${layer} wurde entfernt. Rückgängig: Strg+Z.`,
  added: (layer) => `${layer} wurde hinzugefügt.`,
  opening: "wird geöffnet",
  notOpened: (layer, reason) => `${layer} konnte nicht geöffnet werden. ${reason}`,
  notHere: "Die Ebene ist auf diesem Gerät nicht gespeichert: Öffnen Sie ihre Datei noch einmal.",
  cutOff: (host) =>
    `Es wurden Dateien dieses Geräts gelesen, darum stellt dieser Tab keine Anfragen an ${host}: Laden Sie die Seite neu.`,
  notAStore:
    "An ihrer Adresse liegt ein Volumen, keine Isosplat-Datei: Öffnen Sie das Volumen, um es umzuwandeln.",
  unplaced: (layers, count) =>
    plural(count, {
      one: `${layers}: Die Datei sagt nicht, wo das Volumen liegt. Sein erstes Voxel ist am Ursprung der Welt.`,
      other: `${layers}: Die Dateien sagen nicht, wo die Volumen liegen. Ihre ersten Voxel sind am Ursprung der Welt.`,
    }),
  apart: (layers, first, count) =>
    plural(count, {
      one: `${layers} liegt abseits von ${first}: Ihre Bezugssysteme widersprechen sich, oder sie zeigen verschiedene Orte.`,
      other: `${layers} liegen abseits von ${first}: Ihre Bezugssysteme widersprechen sich, oder sie zeigen verschiedene Orte.`,
    }),
  otherFrame: (layers, first, count) =>
    plural(count, {
      one: `${layers} und ${first} haben verschiedene Bezugssysteme: Ihre Lage zueinander im Bild bedeutet nichts.`,
      other: `${layers} haben andere Bezugssysteme als ${first}: Ihre Lage zueinander im Bild bedeutet nichts.`,
    }),
  andMore: (layers, left) => `${layers} und ${left} weitere`,
  unknownLayers: (layers) =>
    layers === 1
      ? "1 Ebene der Adresse gibt es nicht."
      : `${layers} Ebenen der Adresse gibt es nicht.`,
};
