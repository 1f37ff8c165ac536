// The constraints of one set, coloured and laid out for an executor, and their projection.
#pragma once
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "host/base/array.h"
#include "host/model/model.h"
#include "host/solver/layout.h"
#include "kernels/constraints.h"
#include "kernels/residual.h"

namespace malha {

/// What a person may want to know of a set.
struct SetFacts {
  std::string type;
  int constraints = 0;
  std::vector<int> batch_sizes;  // one a colour
  std::size_t bytes = 0;
};

/// k' = 1 - (1 - k)^(1/n): n projections leave (1 - k) of the error (Müller et al. 2006, section 3.3).
inline double stiffness_per_projection(double k, double projections) { return 1 - std::pow(1 - k, 1.0 / projections); }

template <class Executor, class R>
class Batches {
 public:
  virtual ~Batches() = default;
  virtual void start_substep() = 0;            // forgets lambda
  virtual void project(Vec4<R>* p) const = 0;  // every constraint once, colour after colour
  virtual Residual residual(const Vec4<R>* x, const Vec4<R>* p) const = 0;
  virtual const SetFacts& facts() const = 0;
  virtual bool has_strain() const = 0;
  virtual double compliance() const = 0;  // 0: stiff
};

template <class Kind, Update update, class Executor, class R>
class KindBatches final : public Batches<Executor, R> {
 public:
  KindBatches(const Executor& executor, const Model& model, const ConstraintSet& set) : executor_(executor) {
    const SolverSpec& solver = model.scene.solver;
    const double h = solver.dt / solver.substeps;
    compliance_ = set.compliance.value_or(0);
    kernel_.stiffness = R(stiffness_per_projection(set.stiffness, double(solver.substeps) * solver.iterations));
    kernel_.compliance = R(compliance_ / (h * h));
    lay_out_set(model, set);
  }

  void start_substep() override {
    if constexpr (update == Update::Compliant)
      parallel_for(executor_, static_cast<int>(lambda_.size()), Fill{lambda_.data()});
  }

  void project(Vec4<R>* p) const override {
    auto kernel = kernel_;
    kernel.p = p;
    for (const Batch& batch : batches_) {
      kernel.batch = batch;
      parallel_for(executor_, (batch.count + kLanes<R> - 1) / kLanes<R>, kernel, kPackGrain);
    }
  }

  Residual residual(const Vec4<R>* x, const Vec4<R>* p) const override {
    MeasureResidual<Kind, R> measure{x, p, {}, rest_.data(), 0};
    for (int j = 0; j < Kind::particles; ++j) measure.index[j] = kernel_.index[j];
    Residual total;
    for (const Batch& batch : batches_) {
      measure.begin = batch.begin;
      total += parallel_reduce<Residual>(executor_, batch.count, measure);
    }
    return total;
  }

  const SetFacts& facts() const override { return facts_; }
  bool has_strain() const override { return Kind::has_strain; }
  double compliance() const override { return compliance_; }

 private:
  struct Fill {
    R* lambda;
    KERNEL void operator()(int i) const { lambda[i] = R(0); }
  };

  void lay_out_set(const Model& model, const ConstraintSet& set) {
    std::vector<bool> pinned(model.count());
    for (int i = 0; i < model.count(); ++i) pinned[i] = model.w[i] == 0;
    const Layout layout =
        lay_out(set.particles, set.arity, pinned, colour(set.particles, set.arity, pinned), kLanes<R>);
    batches_ = layout.batches;

    const std::size_t slots = layout.constraint.size();
    std::vector<int> index(slots);
    for (int j = 0; j < set.arity; ++j) {
      for (std::size_t s = 0; s < slots; ++s) index[s] = set.particles[layout.constraint[s] * set.arity + j];
      index_[j] = Array<Executor, int>(index);
      kernel_.index[j] = index_[j].data();
    }
    rest_ = Array<Executor, R>(rest_values(model, set, layout));
    kernel_.rest = rest_.data();
    if constexpr (update == Update::Compliant) lambda_ = Array<Executor, R>(slots, R(0));
    kernel_.lambda = lambda_.data();

    facts_ = {set.type, set.count(), {}, slots * set.arity * sizeof(int) + rest_.bytes() + lambda_.bytes()};
    for (const Batch& batch : batches_) facts_.batch_sizes.push_back(batch.count);
  }

  /// In double whatever R is: rounded once.
  static std::vector<R> rest_values(const Model& model, const ConstraintSet& set, const Layout& layout) {
    std::vector<Vector3<double>> X(model.count());
    for (int i = 0; i < model.count(); ++i) X[i] = {model.x[i][0], model.x[i][1], model.x[i][2]};
    std::vector<double> rest(set.count());
    parallel_for(Serial{}, set.count(), MeasureRest<Kind>{X.data(), set.particles.data(), set.parameter, rest.data()});
    std::vector<R> by_slot(layout.constraint.size());
    for (std::size_t s = 0; s < by_slot.size(); ++s) by_slot[s] = R(rest[layout.constraint[s]]);
    return by_slot;
  }

  Executor executor_;
  Project<Kind, R, update> kernel_{};
  std::vector<Batch> batches_;
  Array<Executor, int> index_[Kind::particles];
  Array<Executor, R> rest_, lambda_;
  double compliance_ = 0;
  SetFacts facts_;
};

/// Looks the set's kind up in the registry.
template <class Executor, class R>
std::unique_ptr<Batches<Executor, R>> make_batches(const Executor& executor, const Model& model,
                                                   const ConstraintSet& set) {
  std::unique_ptr<Batches<Executor, R>> made;
  for_each_constraint([&]<class Kind>(Kind) {
    if (set.type != Kind::name) return;
    if (set.compliance)
      made = std::make_unique<KindBatches<Kind, Update::Compliant, Executor, R>>(executor, model, set);
    else
      made = std::make_unique<KindBatches<Kind, Update::Stiff, Executor, R>>(executor, model, set);
  });
  return made;
}

}  // namespace malha
