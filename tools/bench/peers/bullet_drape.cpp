// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/peers/bullet_drape.h"

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <deque>

#include "host/attachments/pose.h"
#include "host/mesh/topology.h"
#include "host/model/model.h"
#include "host/solver/solver.h"
#include "tools/bench/peers/bullet.h"

namespace malha::bench {

namespace {

btTransform transform_of(const Pose& pose) {
  const auto row = [&](int k) { return to_bullet(Vec3{pose.r[3 * k], pose.r[3 * k + 1], pose.r[3 * k + 2]}); };
  btMatrix3x3 turn;
  for (int k = 0; k < 3; ++k) turn[k] = row(k);
  return btTransform(turn, to_bullet(Vec3{pose.t.x, pose.t.y, pose.t.z}));
}

}  // namespace

struct BulletDrape::Parts {
  /// An environment mesh as a static or kinematic body.
  struct Obstacle {
    std::vector<Keyframe> motion;
    btTriangleMesh triangles;
    std::unique_ptr<btBvhTriangleMeshShape> shape;
    std::unique_ptr<btRigidBody> body;

    explicit Obstacle(const EnvironmentMesh& mesh) : motion(mesh.spec.motion) {
      for (const Vec3& x : mesh.mesh.points) triangles.findOrAddVertex(to_bullet(x), false);
      for (const Triangle& t : malha::triangles(mesh.mesh)) triangles.addTriangleIndices(t[0], t[1], t[2]);
      shape = std::make_unique<btBvhTriangleMeshShape>(&triangles, true);
      shape->setMargin(btScalar(mesh.spec.thickness));
      body = std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, shape.get()));
      body->setFriction(btScalar(mesh.spec.friction));
      if (motion.empty()) return;
      body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      body->setActivationState(DISABLE_DEACTIVATION);
    }
  };

  double dt, time;  // s
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::deque<Obstacle> obstacles;
  std::unique_ptr<btSoftBody> cloth;

  explicit Parts(const Simulation& simulation)
      : dt(simulation.model().scene.solver.dt), time(simulation.solver().time()) {
    Scene scene = simulation.model().scene;
    world.setGravity(to_bullet(scene.gravity));
    world.getWorldInfo().m_gravity = to_bullet(scene.gravity);
    world.getWorldInfo().air_density = 0;
    for (const EnvironmentMesh& mesh : simulation.model().environment) {
      obstacles.emplace_back(mesh);
      world.addRigidBody(obstacles.back().body.get());
    }
    add_cloth(simulation, scene);
  }
  ~Parts() {
    world.getWorldInfo().m_sparsesdf.Reset();  // otherwise each near triangle is searched in all of its cells
    world.removeSoftBody(cloth.get());
    for (Obstacle& o : obstacles) world.removeRigidBody(o.body.get());
  }

  void add_cloth(const Simulation& simulation, Scene& scene) {
    BodySpec& spec = scene.bodies.front();
    const auto& size = std::get<GridShape>(spec.shape).size;
    spec.mass = *spec.density * size[0] * size[1];
    cloth = std::make_unique<btSoftBody>(&world.getWorldInfo());
    bench::add_cloth(*cloth, cloth_of(scene), scene.solver.substeps * scene.solver.iterations);
    const std::vector<Vec3> x = simulation.positions(), v = simulation.velocities();
    for (int i = 0; i < cloth->m_nodes.size(); ++i) {
      btSoftBody::Node& node = cloth->m_nodes[i];
      node.m_x = node.m_q = to_bullet(x[static_cast<std::size_t>(i)]);
      node.m_v = to_bullet(v[static_cast<std::size_t>(i)]);
    }
    btSoftBody::Config& config = cloth->m_cfg;
    config.collisions = btSoftBody::fCollision::SDF_RS;
    config.kDF = btScalar(scene.environment.front().friction);
    cloth->getCollisionShape()->setMargin(btScalar(scene.environment.front().thickness));
    world.addSoftBody(cloth.get());
  }
};

BulletDrape::BulletDrape(const Simulation& simulation) : parts_(std::make_unique<Parts>(simulation)) {}

BulletDrape::~BulletDrape() = default;

void BulletDrape::step() {
  parts_->time += parts_->dt;
  for (auto& o : parts_->obstacles)
    if (!o.motion.empty()) o.body->setWorldTransform(transform_of(pose_at(o.motion, parts_->time)));
  parts_->world.stepSimulation(btScalar(parts_->dt), 0);
}

}  // namespace malha::bench
