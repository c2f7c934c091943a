import "isosplat/react";
import { StrictMode } from "react";
import { createRoot } from "react-dom/client";

// StrictMode mounts every component twice.
createRoot(document.getElementById("app")).render(
  <StrictMode>
    <isosplat-viewer src="STORE" isovalue="100" style={{ width: 400 }} />
  </StrictMode>,
);
