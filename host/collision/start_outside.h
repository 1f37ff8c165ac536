// Bodies at the start, and the solids of the environment.
#pragma once
#include "host/model/model.h"

namespace malha {

/// Refuses a body of which a particle that may move starts deeper in a solid than the solid's thickness. Where the
/// solid says push_out, the whole body is moved out instead, as it is and without velocity, and model.notes says by how
/// much; a body that is held is refused there too, and one for which no way out is found, or that self-collision finds
/// crossing another where it came to.
void start_outside(Model& model);

}  // namespace malha
