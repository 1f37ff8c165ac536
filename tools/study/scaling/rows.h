// The rows of the study "scaling", as its sections read them.
#pragma once
#include <string>
#include <vector>

#include "tools/study/rows.h"
#include "tools/study/study.h"

namespace malha::study {

/// Rows of a kind ("strong", "weak") that were run, a group a method and side, each from one thread on.
std::vector<std::vector<Json>> scaling_groups(const Json& rows, const std::string& kind);

std::string method_of(const Json& row);
std::string count_of(const Json& row);  // "10,000"

Section scaling_passes(const Json& rows);
Section scaling_bandwidth(const Json& rows);
Section scaling_launches(const Json& rows);

}  // namespace malha::study
