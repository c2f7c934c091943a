import type { surfaceTexts as English } from "./surface.ts";

export const surface: typeof English = {
  title: "Fläche speichern",
  lead: (isovalue) => `Die Isofläche bei ${isovalue} als Dreiecke.`,
  format: "Dateiformat",
  formats: {
    stl: "STL, zum Drucken",
    glb: "GLB, für 3D-Programme und das Web",
    ply: "PLY, für MeshLab, CloudCompare und VTK",
  },
  detail: "Auflösung",
  full: (cells) => `Voll: ${cells} Zellen`,
  level: (level, cells) => `Stufe ${level}: ${cells} Zellen`,
  closed: "Geschlossen: mit Flächen, wo das Volumen endet und wo es beschnitten ist",
  clipped: "Nur was innerhalb des Zuschnitts liegt",
  wholeCells:
    "Nur was im Schnittquader liegt, in ganzen Zellen: der Rand hat Stufen von einem Voxel",
  planesNeedClosed:
    "Die Datei wird nicht von schrägen Ebenen geschnitten: Sie schneiden nur eine geschlossene Fläche. „Geschlossen“ braucht manchmal die volle Auflösung.",
  openAtLevel:
    "Bei weniger als der vollen Auflösung wird die Fläche offen gespeichert, außer Sie wählen „Geschlossen“; das braucht manchmal die volle Auflösung.",
  mayNeedFull:
    "Das Schließen braucht manchmal die volle Auflösung: Auf dieser Stufe können fehlende Einzelheiten Löcher lassen.",
  holesOfLevel:
    "Nicht gespeichert: Auf dieser Stufe lässt sich die Fläche nicht schließen, weil fehlende Einzelheiten Löcher in ihr lassen.",
  holesOfMissing:
    "Nicht gespeichert: Die Fläche lässt sich nicht schließen, weil fehlende Voxel Löcher in ihr lassen.",
  chooseFull: "Volle Auflösung wählen",
  leaveOpen: "Offen lassen",
  lengths: {
    mm: {
      stl: "STL-Dateien nennen keine Einheit: Längen sind die des Volumens, in Millimetern.",
      ply: "PLY-Dateien nennen keine Einheit: Längen sind die des Volumens, in Millimetern.",
      glb: "Längen sind die des Volumens, in Metern, wie es in GLB-Dateien üblich ist.",
    },
    voxel: {
      stl: "Die Datei des Volumens nennt keinen Abstand der Voxel: Längen sind in Voxeln. Druckprogramme nehmen ein Voxel als 1 mm.",
      ply: "Die Datei des Volumens nennt keinen Abstand der Voxel: Längen sind in Voxeln.",
      glb: "Die Datei des Volumens nennt keinen Abstand der Voxel: Ein Voxel hat in dieser Datei 1 mm.",
    },
  },
  saving: "Die Fläche wird gespeichert",
  save: "Speichern",
  cancel: "Abbrechen",
  cancelled: "Abgebrochen",
  saved: (triangles, bytes) => `Gespeichert: ${triangles} Dreiecke, ${bytes}`,
  leftOpen: "Sie ist offen: Fehlende Voxel lassen Löcher in ihr.",
  tooLarge: (millions) =>
    `Erwartet wird eine Fläche, die in den Arbeitsspeicher des Browsers und in 4 GB passt, gefunden etwa ${millions} Millionen Zellen: Wählen Sie eine gröbere Auflösung, schneiden Sie das Volumen zu, oder verwenden Sie isosplat extract --mesh`,
  nothing: "Hier ist keine Fläche: Wählen Sie einen anderen Isowert oder einen größeren Quader.",
  about: (triangles, bytes) => `Etwa ${triangles} Dreiecke, ${bytes}.`,
  atMost: (triangles, bytes) => `Höchstens etwa ${triangles} Dreiecke, ${bytes}.`,
  cost: (bytes, time) => `Liest ${bytes} und rechnet etwa ${time}.`,
  aSecond: "eine Sekunde",
  seconds: (n) => `${n} Sekunden`,
};
