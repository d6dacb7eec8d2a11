// SPDX-License-Identifier: Apache-2.0
#include "lucarium/base/json.h"

LUCARIUM_JSON_TEMPLATES(, nlohmann::json)
LUCARIUM_JSON_TEMPLATES(, nlohmann::ordered_json)
