// Tangents of triangle meshes by MikkTSpace. Arithmetic is in single precision and in the order of the reference implementation: which tangents are
// exactly opposite is a question of rounding.
#include "scene/tangent_space.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace cmpg {
namespace {

constexpr std::uint32_t kNone = ~0u;
// Tangents of so many triangles around a vertex are compared in pairs. More count as if none were opposite, so that no file makes that quadratic.
constexpr std::size_t kMostCompared = 256;

bool notZero(float x) { return std::abs(x) > std::numeric_limits<float>::min(); }
bool finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
float length(const glm::vec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

glm::vec3 unit(const glm::vec3& v) { return notZero(v.x) || notZero(v.y) || notZero(v.z) ? (1.0f / length(v)) * v : v; }
glm::vec3 projected(const glm::vec3& v, const glm::vec3& normal) { return unit(v - glm::dot(normal, v) * normal); }

struct Face {
    std::array<std::uint32_t, 3> vertices{};                  // as welded
    std::array<std::uint32_t, 3> neighbours{kNone, kNone, kNone}; // across the edge from corner i to the next
    std::array<bool, 3> grouped{};
    bool degenerate = false;  // two corners in one place
    bool undirected = false;  // its texture coordinates span no area: it joins whatever is beside it and adds nothing
    bool preserving = false;  // texture coordinates turn as corners do
    glm::vec3 s{0}, t{0};     // unit derivatives of the position by u and v
};

class MikkTangents {
  public:
    explicit MikkTangents(const TangentMesh& mesh) : mesh_(mesh), faces_(mesh.corners.size() / 3), tangents_(mesh.corners.size(), glm::vec4(0)) {}

    std::vector<glm::vec4> make() {
        weld();
        for (Face& face : faces_)
            derive(face);
        connect();
        for (std::uint32_t corner = 0; corner < tangents_.size(); ++corner) {
            const Face& face = faces_[corner / 3];
            if (!face.degenerate && !face.undirected && !face.grouped[corner % 3]) {
                collect(corner);
                evaluate();
            }
        }
        copyToDegenerate();
        return std::move(tangents_);
    }

  private:
    struct Edge {
        std::uint32_t low, high, corner; // ends, and the corner that it starts from in its triangle
        bool operator<(const Edge& o) const { return std::tie(low, high, corner) < std::tie(o.low, o.high, o.corner); }
    };
    struct Member {
        std::uint32_t corner;
        bool undirected;
        glm::vec3 s, t; // of its face, projected onto the plane of the vertex
        float angle;    // between its edges in that plane
    };

    // By bits, in which zero has one sign, so that any number is in order.
    std::array<std::uint32_t, 8> key(std::uint32_t v) const {
        const glm::vec3 &p = mesh_.positions[v], &n = mesh_.normals[v];
        const glm::vec2& uv = mesh_.uvs[v];
        std::array<std::uint32_t, 8> bits{};
        const std::array<float, 8> values{p.x, p.y, p.z, n.x, n.y, n.z, uv.x, uv.y};
        std::transform(values.begin(), values.end(), bits.begin(), [](float x) { return std::bit_cast<std::uint32_t>(x + 0.0f); });
        return bits;
    }

    void weld() {
        std::vector<std::uint32_t> order(mesh_.positions.size()), first(order.size());
        std::iota(order.begin(), order.end(), 0u);
        std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
        for (std::size_t i = 0; i < order.size(); ++i)
            first[order[i]] = i > 0 && key(order[i - 1]) == key(order[i]) ? first[order[i - 1]] : order[i];
        for (std::size_t c = 0; c < faces_.size() * 3; ++c)
            faces_[c / 3].vertices[c % 3] = first[mesh_.corners[c]];
    }

    void derive(Face& face) const {
        const auto& [a, b, c] = face.vertices;
        const glm::vec3 &pa = mesh_.positions[a], &pb = mesh_.positions[b], &pc = mesh_.positions[c];
        face.degenerate = pa == pb || pa == pc || pb == pc;
        face.undirected = true;
        const glm::vec3 ab = pb - pa, ac = pc - pa;
        const glm::vec2 duv1 = mesh_.uvs[b] - mesh_.uvs[a], duv2 = mesh_.uvs[c] - mesh_.uvs[a];
        const float area = duv1.x * duv2.y - duv1.y * duv2.x;
        face.preserving = area > 0;
        const glm::vec3 s = duv2.y * ab - duv1.y * ac, t = duv1.x * ac - duv2.x * ab;
        const float lengthS = length(s), lengthT = length(t);
        if (!notZero(area) || !std::isfinite(area) || !notZero(lengthS) || !notZero(lengthT) || !std::isfinite(lengthS) || !std::isfinite(lengthT))
            return;
        const float sign = face.preserving ? 1.0f : -1.0f;
        face.s = (sign / lengthS) * s;
        face.t = (sign / lengthT) * t;
        face.undirected = !notZero(lengthS / std::abs(area)) || !notZero(lengthT / std::abs(area));
    }

    // Triangles that share an edge and run along it in opposite directions are neighbours, two by two in the order of the mesh.
    void connect() {
        std::vector<Edge> edges;
        edges.reserve(tangents_.size());
        for (std::uint32_t corner = 0; corner < tangents_.size(); ++corner) {
            const Face& face = faces_[corner / 3];
            const std::uint32_t from = face.vertices[corner % 3], to = face.vertices[(corner % 3 + 1) % 3];
            if (!face.degenerate)
                edges.push_back({std::min(from, to), std::max(from, to), corner});
        }
        std::sort(edges.begin(), edges.end());
        const auto upwards = [&](const Edge& e) { return faces_[e.corner / 3].vertices[e.corner % 3] == e.low; };
        std::size_t open = 0; // the first edge that waits for a partner; all that wait run the same way
        std::vector<std::uint32_t> waiting;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            const Edge& e = edges[i];
            if (i == 0 || e.low != edges[i - 1].low || e.high != edges[i - 1].high) {
                waiting.clear();
                open = 0;
            }
            if (open == waiting.size() || upwards(edges[waiting[open]]) == upwards(e)) {
                waiting.push_back(std::uint32_t(i));
                continue;
            }
            const std::uint32_t other = edges[waiting[open++]].corner;
            faces_[e.corner / 3].neighbours[e.corner % 3] = other / 3;
            faces_[other / 3].neighbours[other % 3] = e.corner / 3;
        }
    }

    // The corners around a vertex that are reached from one of them over shared edges and have its orientation.
    void collect(std::uint32_t first) {
        members_.clear();
        const Face& start = faces_[first / 3];
        const std::uint32_t vertex = start.vertices[first % 3];
        preserving_ = start.preserving;
        const auto take = [&](std::uint32_t corner) {
            Face& face = faces_[corner / 3];
            face.grouped[corner % 3] = true;
            members_.push_back({corner, face.undirected, {}, {}, 0});
            for (const std::uint32_t edge : {corner % 3, (corner % 3 + 2) % 3})
                pending_.push_back(face.neighbours[edge]);
        };
        take(first);
        while (!pending_.empty()) {
            const std::uint32_t at = pending_.back();
            pending_.pop_back();
            if (at == kNone)
                continue;
            Face& face = faces_[at];
            const auto i = std::uint32_t(std::find(face.vertices.begin(), face.vertices.end(), vertex) - face.vertices.begin());
            if (face.grouped[i])
                continue;
            if (face.undirected && !face.grouped[0] && !face.grouped[1] && !face.grouped[2])
                face.preserving = preserving_; // its first group decides
            if (face.preserving == preserving_)
                take(3 * at + i);
        }
        std::sort(members_.begin(), members_.end(), [](const Member& a, const Member& b) { return a.corner < b.corner; });
    }

    // Each member's tangent is the mean over all members but those that are opposite to it, weighted by angles.
    void evaluate() {
        for (Member& m : members_) {
            const Face& face = faces_[m.corner / 3];
            const std::uint32_t i = m.corner % 3, here = face.vertices[i];
            const glm::vec3 &normal = mesh_.normals[here], &p = mesh_.positions[here];
            m.s = projected(face.s, normal);
            m.t = projected(face.t, normal);
            const glm::vec3 before = projected(mesh_.positions[face.vertices[(i + 2) % 3]] - p, normal);
            const glm::vec3 after = projected(mesh_.positions[face.vertices[(i + 1) % 3]] - p, normal);
            m.angle = float(std::acos(double(std::clamp(glm::dot(before, after), -1.0f, 1.0f))));
        }
        const auto mean = [&](const auto& counts) {
            glm::vec3 sum(0);
            for (const Member& m : members_)
                if (!m.undirected && counts(m))
                    sum += m.angle * m.s;
            sum = unit(sum);
            return sum != glm::vec3(0) && finite(sum) ? glm::vec4(sum, preserving_ ? 1 : -1) : glm::vec4(0);
        };
        const bool compared = members_.size() <= kMostCompared;
        const glm::vec4 ofAll = compared ? glm::vec4(0) : mean([](const Member&) { return true; });
        for (const Member& m : members_)
            tangents_[m.corner] = !compared ? ofAll : mean([&](const Member& o) {
                return m.undirected || o.corner == m.corner || (glm::dot(m.s, o.s) > -1 && glm::dot(m.t, o.t) > -1);
            });
    }

    // From the first corner of the mesh with the same vertex.
    void copyToDegenerate() {
        std::vector<std::uint32_t> first(mesh_.positions.size(), kNone);
        for (const bool degenerate : {false, true})
            for (std::uint32_t corner = 0; corner < tangents_.size(); ++corner) {
                const Face& face = faces_[corner / 3];
                std::uint32_t& at = first[face.vertices[corner % 3]];
                if (face.degenerate != degenerate)
                    continue;
                if (!degenerate)
                    at = std::min(at, corner);
                else if (at != kNone)
                    tangents_[corner] = tangents_[at];
            }
    }

    const TangentMesh& mesh_;
    std::vector<Face> faces_;
    std::vector<glm::vec4> tangents_; // of corners
    std::vector<Member> members_;     // of the group that is made
    std::vector<std::uint32_t> pending_;
    bool preserving_ = false; // its orientation
};

} // namespace

std::vector<glm::vec4> mikkTangents(const TangentMesh& mesh) { return MikkTangents(mesh).make(); }

} // namespace cmpg
