// SPDX-License-Identifier: Apache-2.0
// Images are decoded when they are first shown, and forgotten again when other scenes are.

const decoded = new Map();       // id → promise of an image
const linkedImages = new Map();  // id → function that takes the base64 text
window.receiveImage = (id, text) => linkedImages.get(id)(text);
const pageLoaded = new Promise(done => {
  if (document.readyState !== 'loading')
    done();
  else
    document.addEventListener('DOMContentLoaded', done, {once: true});
});

// Images in the page stand behind the script, so that tables and plots appear before they are read.
async function imageText(id, entry) {
  if (!entry.file) {
    if (!document.getElementById(`image-${id}`)) await pageLoaded;
    return document.getElementById(`image-${id}`).textContent;
  }
  return new Promise((done, fail) => {
    linkedImages.set(id, done);
    document.head.append(
        h('script', {src: entry.file, onerror: () => fail(new Error(`${entry.file} is missing beside this page`))}));
  });
}

function loadImage(id) {
  if (!decoded.has(id)) {
    decoded.set(id, imageText(id, imageList.images[id]).then(text => decodeImage(imageList.images[id], text)));
  }
  return decoded.get(id);
}

function forgetOtherScenes(scene) {
  for (const id of decoded.keys())
    if (imageList.images[id].scene !== scene) decoded.delete(id);
}

// The id of the image that matches all of `wanted`, or -1.
function findImage(wanted) {
  return imageList.images.findIndex(entry => Object.entries(wanted).every(([key, value]) => entry[key] === value));
}

// Layers of a scene and budget, in the order of their first appearance.
function layerNames(scene, budget) {
  const names = new Set();
  for (const entry of imageList.images) {
    if (entry.kind === 'layer' && entry.scene === scene && (entry.of === 'reference' || entry.budget === budget))
      names.add(entry.layer);
  }
  return [...names];
}
