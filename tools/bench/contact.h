// SPDX-License-Identifier: Apache-2.0
// malha bench contact: what contact with the environment costs a particle and substep.
#pragma once
#include <string>
#include <vector>

#include "tools/bench/counts.h"

namespace malha::bench {

struct ContactOptions : MeasuringOptions {
  std::vector<std::string> cases;  // names of contact_cases(); empty: all
  int bullet_frames = 0;           // of each cloth on a scan by Bullet, some seconds each; 0: it is not run
  std::string scenes = "scenes";   // the folder of the shipped scenes and their meshes
};

/// Scenes that ship, and cloths of 40,000 or 100,000 particles on a scan that turns at 450 degrees/s.
const std::vector<std::string>& contact_cases();

/// Runs, prints a table as it goes, and writes contact.json (the rows), contact_machine.json and contact.txt into the
/// folder. Throws InputError, Diverged, and std::runtime_error where something cannot be written.
void run_contact(const ContactOptions& options);

}  // namespace malha::bench
