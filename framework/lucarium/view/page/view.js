// SPDX-License-Identifier: Apache-2.0
(() => {
'use strict';
@include dom.js@
@include format.js@
@include colors.js@
@include image_decoding.js@
@include tone.js@
@include pixels.js@
@include connection.js@
@include picture.js@
@include camera.js@
@include camera_input.js@
@include parameter_controls.js@
@include technique_panel.js@
@include picture_panel.js@
@include camera_panel.js@
@include state_panels.js@
@include viewer_start.js@
startViewer();
})();
