// SPDX-License-Identifier: Apache-2.0
// Access to the fields of a study's rows.
#pragma once
#include <string>

#include "tools/study/cells.h"

namespace malha::study {

/// The number of this key; 0 if the row has none.
inline double number(const Json& row, const std::string& key) { return row.contains(key) ? row[key].get<double>() : 0; }

/// Copies the machine that measured the cell into the row, if cells come from several machines.
inline void copy_machine(Json& row, const Json& cell) {
  if (cell.contains("machine")) row["machine"] = cell["machine"];
}

inline std::string text(const Json& row, const std::string& key) { return row.at(key).get<std::string>(); }

}  // namespace malha::study
