// Serves this folder on this computer, because browsers do not load modules from files. `node serve.mjs`

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const ROOT = fileURLToPath(new URL(".", import.meta.url));
const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".mjs": "text/javascript" };

// Starts the server and returns it with its address.
export function serve(port = 0) {
  const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
    try {
      const content = await readFile(ROOT + path);
      response.writeHead(200, { "Content-Type": TYPES[extname(path)] ?? "application/octet-stream" });
      response.end(content);
    } catch {
      response.writeHead(404);
      response.end();
    }
  });
  return new Promise((ready) => {
    server.listen(port, "127.0.0.1", () => {
      ready({ server, address: `http://127.0.0.1:${server.address().port}/index.html` });
    });
  });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  console.log((await serve(8080)).address);
}
