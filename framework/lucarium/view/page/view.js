// SPDX-License-Identifier: Apache-2.0
@include chart.js@
(() => {
'use strict';
@include dom.js@
@include format.js@
@include colors.js@
@include image_decoding.js@
@include tone.js@
@include pixels.js@
@include charts.js@
@include connection.js@
@include picture.js@
@include camera.js@
@include camera_input.js@
@include parameter_controls.js@
@include technique_panel.js@
@include picture_panel.js@
@include camera_panel.js@
@include beside_panel.js@
@include path_panel.js@
@include inspect_panel.js@
@include truth_panel.js@
@include scene_panel.js@
@include state_panels.js@
@include viewer_start.js@
startViewer();
})();
