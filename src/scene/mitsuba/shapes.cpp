// Shapes of a Mitsuba scene: meshes and analytic shapes become triangles in world space.
#include "base/error.h"
#include "base/parallel.h"
#include "scene/mitsuba/load.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace cmpg {
namespace {

bool isMeshFile(const std::string& type) { return type == "obj" || type == "ply"; }

class ShapeLoader {
  public:
    explicit ShapeLoader(MitsubaLoad& load) : load_(load), materials_(load) {}
    void run();

  private:
    void collect(const MitsubaObject& shape, std::vector<MitsubaObject>& shapes);
    void readMeshes(const std::vector<MitsubaObject>& shapes);
    void add(const MitsubaObject& shape);
    const Mesh& meshOf(const MitsubaObject& shape, glm::dmat4& toWorld);
    void addMesh(const MitsubaObject& shape, const Mesh& mesh, const glm::dmat4& toWorld, std::uint32_t material);

    MitsubaLoad& load_;
    MitsubaMaterials materials_;
    std::map<std::pair<std::string, bool>, Mesh> files_; // by file, and whether its normals are read
    std::map<std::string, Mesh> analytic_;
    std::uint64_t vertices_ = 0;
};

std::string fileOf(const MitsubaObject& shape) {
    const std::string file = shape.string("filename", "");
    if (file.empty())
        shape.fail("the shape needs a filename");
    return file;
}

// The shape, or those that it merges.
void ShapeLoader::collect(const MitsubaObject& shape, std::vector<MitsubaObject>& shapes) {
    constexpr std::size_t kMostShapes = std::size_t(1) << 20;
    if (shape.type() != "merge") {
        shapes.push_back(shape);
        return;
    }
    for (const MitsubaObject& part : shape.objects("shape")) {
        if (part.type() == "merge")
            part.fail("a merge within a merge is not supported", "", "put its shapes into the outer one");
        if (shapes.size() == kMostShapes)
            shape.fail("the merge brings the scene to more than " + std::to_string(kMostShapes) + " shapes", "it is used too often", "simplify the scene");
        shapes.push_back(part);
    }
    load_.noteUnread(shape);
}

// All files at once, each once.
void ShapeLoader::readMeshes(const std::vector<MitsubaObject>& shapes) {
    struct Job {
        const MitsubaObject* shape;
        std::string file;
        bool smooth;
        Mesh* result;
    };
    std::vector<Job> jobs;
    for (const MitsubaObject& shape : shapes) {
        if (!isMeshFile(shape.type()))
            continue;
        const bool smooth = !shape.boolean("face_normals", false);
        const auto [at, isNew] = files_.try_emplace({fileOf(shape), smooth});
        if (isNew)
            jobs.push_back({&shape, at->first.first, smooth, &at->second});
    }
    parallelFor(jobs.size(), 1, [&](std::size_t begin, std::size_t) {
        const Job& job = jobs[begin];
        const MitsubaElement& at = *job.shape->find("filename");
        const auto read = job.shape->type() == "ply" ? readPly : readObj;
        Mesh mesh = read(load_.document.read(at, job.file), load_.document.place(at) + ": " + job.file);
        if (!job.smooth)
            mesh.normals.clear();
        *job.result = std::move(mesh);
    });
}

const Mesh& ShapeLoader::meshOf(const MitsubaObject& shape, glm::dmat4& toWorld) {
    const std::string& type = shape.type();
    const auto analytic = [&](Mesh (*make)()) -> const Mesh& {
        const auto found = analytic_.find(type);
        return found == analytic_.end() ? analytic_.emplace(type, make()).first->second : found->second;
    };
    if (isMeshFile(type))
        return files_.at({fileOf(shape), !shape.boolean("face_normals", false)});
    if (type == "rectangle")
        return analytic(rectangleMesh);
    if (type == "cube")
        return analytic(cubeMesh);
    if (type == "disk")
        return analytic(diskMesh);
    if (type == "sphere") {
        const glm::dvec3 center = shape.point("center").value_or(glm::dvec3(0));
        toWorld = toWorld * glm::translate(glm::dmat4(1), center) * glm::scale(glm::dmat4(1), glm::dvec3(shape.real("radius", 1, 0)));
        return analytic(sphereMesh);
    }
    if (type == "cylinder") {
        const glm::dvec3 p0 = shape.point("p0").value_or(glm::dvec3(0)), p1 = shape.point("p1").value_or(glm::dvec3(0, 0, 1));
        const glm::dvec3 n = glm::normalize(p1 - p0);
        if (!std::isfinite(n.x))
            shape.fail("the cylinder has no length");
        const auto [s, t] = mitsubaFrame(n); // texture coordinates begin at s
        const double radius = shape.real("radius", 1, 0);
        toWorld = toWorld * glm::dmat4(glm::dvec4(radius * s, 0), glm::dvec4(radius * t, 0), glm::dvec4(p1 - p0, 0), glm::dvec4(p0, 1));
        return analytic(cylinderMesh);
    }
    shape.fail("the shape " + type + " is not supported",
               type == "serialized" ? "meshes are read from Wavefront OBJ and PLY" : type == "instance" || type == "shapegroup" ? "instances are not read" : "",
               type == "serialized" ? "convert it to .ply" : "use obj, ply, rectangle, cube, disk, sphere or cylinder");
}

void ShapeLoader::addMesh(const MitsubaObject& shape, const Mesh& mesh, const glm::dmat4& toWorld, std::uint32_t material) {
    const bool flip = shape.boolean("flip_normals", false), faceNormals = shape.boolean("face_normals", false);
    // Readers count v as their format does by default.
    const bool turnUvs = isMeshFile(shape.type()) && shape.boolean("flip_tex_coords", shape.type() == "obj") != (shape.type() == "obj");
    const std::uint64_t most = load_.options.maxTriangles;
    vertices_ += mesh.positions.size() + 1;
    if (load_.geometry.triangles() + mesh.triangles.size() > most || vertices_ > 3 * most)
        shape.fail("the shape brings the scene to more than " + std::to_string(most) + " triangles or three times as many vertices",
                   "the meshes are too detailed, or used too often", "simplify the scene");
    const bool smooth = !faceNormals, generated = smooth && mesh.normals.empty();
    load_.checkTexcoords(material, !mesh.uvs.empty(), false);
    load_.geometry.provide({smooth, !mesh.uvs.empty(), false, false, false});
    const glm::dmat3 linear(toWorld), cofactor = cofactorMatrix(linear);
    std::vector<glm::dvec3> positions;
    for (const glm::dvec3& p : mesh.positions) {
        positions.emplace_back(toWorld * glm::dvec4(p, 1));
        if (!fitsFloats(positions.back()))
            shape.fail("the shape leaves the range of numbers", "its transform scales too much", "check the transform");
    }
    // Normals stay on their side of a mirrored surface, but Mitsuba turns a mirrored sphere inside out. Generated ones follow the corners as they lie in
    // the scene.
    const bool stay = !generated && shape.type() != "sphere";
    const double sign = (stay && glm::determinant(linear) < 0 ? -1 : 1) * (flip ? -1 : 1);
    std::vector<glm::vec3> normals = generated ? smoothNormals(positions, mesh.triangles) : mesh.normals;
    for (glm::vec3& normal : normals)
        normal = generated ? float(sign) * normal : unitOrZero(sign * (cofactor * glm::dvec3(normal)));
    std::uint32_t first = 0;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        Vertex vertex;
        vertex.position = positions[i];
        if (smooth)
            vertex.normal = normals[i];
        if (!mesh.uvs.empty())
            vertex.uv0 = turnUvs ? glm::vec2(mesh.uvs[i].x, 1 - mesh.uvs[i].y) : mesh.uvs[i];
        const std::uint32_t index = load_.geometry.add(vertex);
        if (i == 0)
            first = index;
    }
    for (const glm::uvec3& t : mesh.triangles) {
        // Mitsuba emits to where the vertices' normals point, we to where corners go round counter-clockwise.
        const glm::dvec3 face = glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]);
        const bool turn = normals.empty() ? flip : glm::dot(face, glm::dvec3(normals[t.x] + normals[t.y] + normals[t.z])) < 0;
        load_.geometry.add(Triangle{{first + t.x, first + (turn ? t.z : t.y), first + (turn ? t.y : t.z)}, material});
    }
}

void ShapeLoader::add(const MitsubaObject& shape) {
    const std::vector<MitsubaObject> bsdfs = shape.objects("bsdf"), emitters = shape.objects("emitter");
    if (bsdfs.size() > 1 || emitters.size() > 1)
        shape.fail("the shape has more than one " + std::string(bsdfs.size() > 1 ? "bsdf" : "emitter"));
    for (const char* medium : {"interior", "exterior"})
        if (const MitsubaElement* e = shape.find(medium))
            load_.document.fail(*e, "participating media are not supported", "", "leave the medium out");
    glm::dmat4 toWorld = load_.toScene * shape.transform("to_world").value_or(glm::dmat4(1));
    const Mesh& mesh = meshOf(shape, toWorld);
    const std::optional<std::uint32_t> material =
        materials_.of(bsdfs.empty() ? nullptr : &bsdfs[0], emitters.empty() ? nullptr : &emitters[0], load_.nameOf(shape, "shape"));
    if (material)
        addMesh(shape, mesh, toWorld, *material);
    if (shape.find("max_smooth_angle"))
        load_.warn("max_smooth_angle is left out: edges that it would keep sharp are smooth; save the meshes with normals, or give face_normals");
    shape.ignore({"silhouette_sampling_weight", "collapse", "max_smooth_angle", "flip_normals"});
    load_.noteUnread(shape);
}

void ShapeLoader::run() {
    std::vector<MitsubaObject> shapes;
    for (const MitsubaElement* e : load_.document.contents())
        if (load_.document.resolve(*e).tag == "shape")
            collect(MitsubaObject(load_.document, *e), shapes);
    readMeshes(shapes);
    for (const MitsubaObject& shape : shapes)
        add(shape);
}

} // namespace

void loadMitsubaShapes(MitsubaLoad& load) { ShapeLoader(load).run(); }

} // namespace cmpg
