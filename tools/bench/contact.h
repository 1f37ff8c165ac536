// SPDX-License-Identifier: Apache-2.0
// malha bench contact: the time of contact with the environment, per particle and substep.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/counts.h"

namespace malha::bench {

struct ContactOptions : MeasuringOptions {
  std::vector<std::string> cases;  // names of contact_cases(); empty: all
  int bullet_frames = 0;           // frames of each cloth on a scan that Bullet runs, some seconds each; 0: none
  std::string scenes = "scenes";   // folder of the shipped scenes and their meshes
};

/// Names of the cases: shipped scenes, and cloths of 40,000 or 100,000 particles on a scan that turns at 450 degrees/s.
const std::vector<std::string>& contact_cases();

/// Runs the benchmark, prints its table line by line, and writes contact.json (the rows), contact_machine.json and
/// contact.txt into the folder. Throws InputError, Diverged, and std::runtime_error if a file cannot be written.
void run_contact(const ContactOptions& options);

}  // namespace malha::bench
