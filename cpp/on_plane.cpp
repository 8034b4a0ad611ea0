#include "on_plane.hpp"

#include "plane_frame.hpp"
#include "side.hpp"

namespace feeler_oracle {

int planar_face_at(const Core& core, const std::array<double, 3>& c) {
    const Q3 point = exact(c);
    for (std::size_t i = 0; i < core.model().faces.size(); ++i) {
        const auto* plane = std::get_if<Plane>(&core.model().faces[i].surface);
        if (!plane) continue;
        const Frame frame(*plane);
        if (sign(frame.normal2) == 0) continue;
        const Q3 w = minus(point, frame.origin);
        if (sign(dot(frame.normal, w)) != 0) continue;
        const auto ab = frame.coordinates(w);
        const Q u = frame.parameter(0, ab[0]), v = frame.parameter(1, ab[1]);
        if (side(core.face(i).region, u, v) != Side::Outside) return int(i);
    }
    return -1;
}

}  // namespace feeler_oracle
