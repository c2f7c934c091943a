import type { helpTexts as English } from "./help.ts";

export const help: typeof English = {
  title: "Tasten und Gesten",
  rows: [
    ["Ziehen, ein Finger, Pfeiltasten", "Drehen"],
    ["Rechts ziehen, Umschalt + Ziehen, zwei Finger, Umschalt + Pfeile", "Verschieben"],
    ["Mausrad, zwei Finger spreizen, + und −", "Vergrößern und verkleinern"],
    ["Doppelklick", "Diesen Punkt der Fläche zum Drehpunkt machen"],
    ["Klick, I", "Die Ebene nennen, mit dem Rauminhalt ihres Labels; I: in der Mitte des Bildes"],
    ["L + Ziehen", "Das Hauptlicht bewegen"],
    [
      "Einen Griff des Schnittquaders ziehen, Pfeiltasten auf ihm",
      "Eine Seite verschieben; die Griffe sind zu sehen, solange der Abschnitt Schnitt geöffnet ist",
    ],
    ["[ und ]", "Den Isowert senken oder erhöhen; mit Umschalt in kleinen Schritten"],
    [", und .", "In der Zeit einen Schritt zurück oder vor"],
    ["K", "Eine Szene, die sich mit der Zeit ändert, abspielen oder anhalten"],
    ["1 … 6", "Vorn, hinten, links, rechts, oben, unten"],
    ["V", "Das ganze Volumen zeigen, ohne zu drehen"],
    ["P", "Perspektivisch oder orthografisch"],
    [
      "M",
      "Abstände messen: Enter nimmt die Bildmitte, Umschalt + Enter beendet einen Streckenzug, Escape beendet das Messen",
    ],
    ["R", "Ansicht zurücksetzen"],
    [
      "Strg + Z, Strg + Umschalt + Z",
      "Die letzte Änderung der Ansicht zurücknehmen oder wiederholen",
    ],
    [
      "Pfeiltasten, Alt + Pfeile, F2, Entf in der Liste der Ebenen",
      "Zu einer anderen Ebene gehen, sie in der Liste verschieben, umbenennen, entfernen",
    ],
    ["C", "Einen Link zu dieser Ansicht kopieren"],
    ["S, Umschalt + S", "Ein Bild speichern; eines beliebiger Größe oder einen Film"],
    ["F", "Das Bedienfeld zeigen oder verbergen"],
    ["T", "Dunkle oder helle Darstellung"],
    ["?", "Diese Hilfe"],
  ],
  address:
    "Die Adresse dieser Seite enthält immer die ganze Ansicht: Volumen, Isowerte, Kamera, Farben.",
};
