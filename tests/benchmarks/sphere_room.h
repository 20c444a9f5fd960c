#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/scene.h"

#include <memory>
#include <vector>

namespace structnerf {

struct SphereRoomCamera;

// Stands in for a scene: cameras inside a hollow sphere that fills the unit
// box, with a smooth pattern on its wall. The objective asks for the colour and
// the depth of the wall, so that a field learns a surface and rays are sampled
// the way they are in a room.
class SphereRoomObjective : public TileObjective {
 public:
  SphereRoomObjective();
  ~SphereRoomObjective() override;

  void DrawRays(int step, int tile, RayTile* rays) override;
  LossValues Evaluate(const RayOutputs& outputs,
                      RayGradients* gradients) override;

 private:
  std::vector<std::unique_ptr<SphereRoomCamera>> cameras_;
  RayTile rays_;
  PerRay<float> color_[3];
  PerRay<float> depth_;
};

// One per thread of the engine.
std::vector<std::unique_ptr<TileObjective>> SphereRoomObjectives(
    const RenderEngine& engine);

// Z-depth at which a ray of such a camera meets the wall.
float SphereRoomDepth(const RayTile& rays, int ray);

// The cameras, 640x480, and points on the wall, for what depends on a scene.
Scene SphereRoomScene();

// Rays of all pixels of a view of the room, in tiles of neighbouring pixels.
std::vector<RayTile> SphereRoomView(int width, int height);

}  // namespace structnerf
