// SPDX-License-Identifier: Apache-2.0
// Instantiation of the solvers for the executors of the host.
#include "host/solver/instantiate.h"
#include "host/solver/test_executor_hook.h"
#if defined(MALHA_HAS_CUDA)
#include "host/solver/backend_cuda.h"
#endif

namespace malha {

std::vector<std::string> instruction_sets() {
  std::vector<std::string> names;
  for_each_isa([&]<class Isa>(Isa) { names.push_back(Isa::name); });
  return names;
}

std::unique_ptr<Solver> make_solver(const Model& model, const OpenMP& threads, const std::string& instructions,
                                    const ShowProgress& progress) {
  if (make_solver_hook != nullptr && instructions.empty()) return make_solver_hook(model, threads.threads);
  const std::string wanted = instructions.empty() ? instruction_sets().back() : instructions;
  std::unique_ptr<Solver> made;
  for_each_isa([&]<class Isa>(Isa) {
    if (wanted != Isa::name) return;
    const int count = threads.threads > 0 ? threads.threads : 1;
    // With one thread every launch is serial.
    made = instantiate(model, OpenMP{count, Isa::value, threads.caller}, count, progress);
  });
  if (!made) throw InputError("instructions: this build on this CPU has no \"" + wanted + "\"");
  return made;
}

#if defined(MALHA_HAS_CUDA)
template <class Kernel>
void deal_on_host(const OpenMP& host, int groups, const Kernel& kernel) {
  parallel_region(host, groups, [&](const auto& team) { parallel_for_interleaved(team, groups, kernel); });
}
template void deal_on_host(const OpenMP&, int, const FindContact<float>&);
template void deal_on_host(const OpenMP&, int, const FindContact<double>&);
template void deal_on_host(const OpenMP&, int, const ClampTunnelling<float>&);
template void deal_on_host(const OpenMP&, int, const ClampTunnelling<double>&);
template void deal_on_host(const OpenMP&, int, const ClampRestitution<float>&);
template void deal_on_host(const OpenMP&, int, const ClampRestitution<double>&);
template void deal_on_host(const OpenMP&, int, const RecordTunnelling<float>&);
template void deal_on_host(const OpenMP&, int, const RecordTunnelling<double>&);

std::unique_ptr<Solver> make_solver_on_cuda(const Model& model, int threads, const ShowProgress& progress, bool timed) {
  return instantiate_on_cuda(model, OpenMP{threads > 0 ? threads : 1, widest_instructions()}, progress, timed);
}
#else
void require_cuda() {
  throw InputError("backend: found \"cuda\", which this build of malha is made without; allowed: openmp, serial");
}
std::unique_ptr<Solver> make_solver_on_cuda(const Model&, int, const ShowProgress&, bool) {
  require_cuda();
  return nullptr;
}
DeviceStats cuda_device() {
  require_cuda();
  return {};
}
#endif

}  // namespace malha
