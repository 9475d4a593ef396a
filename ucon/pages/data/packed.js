// Data contained in the page: compressed, in base64.
'use strict';

/** Plain values of a packed element; each is unpacked once. */
const unpacked = new Map();
function unpack(id) {
  if (!unpacked.has(id)) {
    const bytes = bytesOf(id);
    unpacked.set(id, new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).json());
  }
  return unpacked.get(id);
}
function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  return bytes;
}
