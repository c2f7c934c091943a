import type { faultTexts as English } from "./faults.ts";

export const fault: typeof English = {
  unreachable: {
    title: "Der Server antwortet nicht",
    text: "„NAME“ ist nicht erreichbar: Vielleicht startet der Server gerade, oder die Verbindung ist unterbrochen. Es wird von selbst erneut versucht.",
  },
  "server-fault": {
    title: "Der Server antwortet mit einem Fehler",
    text: "Vielleicht startet er gerade, ist überlastet oder außer Betrieb. „NAME“ wird von selbst erneut versucht.",
  },
  "cors-refused": {
    title: "Dieser Host lässt andere Sites seine Dateien nicht lesen",
    text: "Der Host von „NAME“ antwortet, enthält seine Antwort aber dieser Seite vor (CORS); oder die Datei ist nicht da. Sein Betreiber muss mit jeder Antwort, auch mit Fehlern, „Access-Control-Allow-Origin: *“ senden (nginx: add_header … always; isosplat serve: --cors) und sollte „Access-Control-Expose-Headers: Content-Range, Content-Length, ETag“ senden.",
  },
  "access-denied": {
    title: "Der Server verweigert den Zugriff",
    text: "„NAME“ ist nicht öffentlich oder nicht da. Öffnen Sie die ganze Adresse oder den Link, den Sie bekommen haben: Er kann abgelaufen sein. Oder bitten Sie den Eigentümer von „NAME“ um Zugriff.",
  },
  "not-found": {
    title: "Dieses Volumen gibt es nicht",
    text: "Es gibt kein Volumen „NAME“. Vielleicht wurde es umbenannt oder entfernt. Kommt es wieder, wird es von selbst geöffnet.",
  },
  replaced: {
    title: "Das Volumen wurde ersetzt",
    text: "„NAME“ ist jetzt eine andere Isosplat-Datei. Sie wird von selbst geöffnet.",
  },
  "cut-short": {
    title: "Die Isosplat-Datei ist abgeschnitten",
    text: "Die Datei von „NAME“ ist kürzer, als ihr Anfang angibt. Kopieren Sie sie noch einmal ganz, oder erzeugen Sie sie neu mit „isosplat build“.",
  },
  "no-range": {
    title: "Dieser Host liefert keine Teile von Dateien",
    text: "Isosplat liest Isosplat-Dateien in Teilen, mit HTTP-Range-Anfragen, und dieser Host antwortet mit der ganzen Datei, was nur für Dateien bis 16 MB genügt. Legen Sie die Datei auf einen Host, der Range unterstützt (nginx, S3 und die meisten Objektspeicher), oder liefern Sie sie mit „isosplat serve“ aus.",
  },
  "not-a-store": {
    title: "Das ist keine Isosplat-Datei",
    text: "Was unter der Adresse von „NAME“ liegt, wurde nicht von Isosplat erzeugt. Prüfen Sie die Adresse, oder erzeugen Sie eine Isosplat-Datei mit „isosplat build“.",
  },
  "newer-version": {
    title: "Diese Isosplat-Datei ist neuer als diese Seite",
    text: "„NAME“ wurde mit einer neueren Version von Isosplat erzeugt als der dieser Seite. Öffnen Sie die Datei mit jener Version, oder erzeugen Sie sie neu mit dieser.",
  },
  "damaged-header": {
    title: "Die Isosplat-Datei ist beschädigt",
    text: "Der Anfang von „NAME“ hat sich geändert, seit er geschrieben wurde. Kopieren Sie die Datei noch einmal, oder erzeugen Sie sie neu mit „isosplat build“.",
  },
  "damaged-page": {
    title: "Die Isosplat-Datei ist beschädigt",
    text: "Ein Teil ihres Verzeichnisses kam zweimal mit falscher Prüfsumme an; der Rest wird gezeigt. Kopieren Sie die Datei noch einmal, oder erzeugen Sie sie neu mit „isosplat build“.",
  },
  "damaged-part": {
    title: "Die Isosplat-Datei ist beschädigt",
    text: "Teile davon kamen zweimal mit falscher Prüfsumme an; an ihrer Stelle werden gröbere gezeigt. Kopieren Sie die Datei noch einmal, oder erzeugen Sie sie neu mit „isosplat build“.",
  },
  "out-of-memory": {
    title: "Der Arbeitsspeicher ist voll",
    text: "Das Bild ist gröber, als der Bildschirm zeigen könnte. Schließen Sie andere Programme oder Tabs, und versuchen Sie es erneut.",
  },
  "worker-lost": {
    title: "Der Browser hat einen Worker beendet, der Daten dekodiert",
    text: "Vielleicht fehlt dem Browser Arbeitsspeicher. Der Worker wird von selbst neu gestartet. Schließen Sie andere Tabs, falls diese Meldung bleibt.",
  },
  "no-webgl2": {
    title: "Dieser Browser bietet kein WebGL 2",
    text: "Isosplat zeichnet mit WebGL 2. Schalten Sie in den Einstellungen des Browsers die Hardwarebeschleunigung ein, erneuern Sie den Grafiktreiber, oder öffnen Sie diese Adresse in einem aktuellen Firefox, Chrome, Edge oder Safari.",
  },
  "context-lost": {
    title: "Der Browser hat die Grafikkarte entzogen",
    text: "Das Bild kommt wieder, wenn der Browser sie zurückgibt.",
  },
  "renderer-failed": {
    title: "Das Bild kann nicht gezeichnet werden",
    text: "Der Grafiktreiber hat einen Fehler gemeldet. Versuchen Sie es erneut; hilft das nicht, starten Sie den Browser neu.",
  },
  "bad-address": {
    title: "Das ist nicht die Adresse einer Isosplat-Datei",
    text: "„NAME“ kann nicht geladen werden. Geben Sie die http- oder https-Adresse einer Isosplat-Datei an, wie https://example.org/head.isosplat.",
  },
  internal: {
    title: "Etwas ist schiefgegangen",
    text: "Das ist ein Fehler der Seite, nicht Ihrer Daten. Laden Sie die Seite neu, und melden Sie die Einzelheiten, falls er wiederkommt.",
  },
};
