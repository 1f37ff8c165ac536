// SPDX-License-Identifier: Apache-2.0
// Style, markup and scripts that every page contains, compiled into the library from host/output/page/.
#pragma once

namespace malha::page_parts {

extern const char* const kStyle;     // style.css
extern const char* const kBody;      // body.html
extern const char* const kThree;     // three.js, see threejs.org
extern const char* const kControls;  // its OrbitControls.js
extern const char* const kData;      // data.js
extern const char* const kLooks;     // looks.js
extern const char* const kStage;     // stage.js
extern const char* const kPanel;     // panel.js
extern const char* const kViewer;    // viewer.js

}  // namespace malha::page_parts
