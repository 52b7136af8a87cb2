// Writes a Mitsuba scene back with changed parameters: the tree as it was read, variables replaced and included files in place.
#include "base/error.h"
#include "base/log.h"
#include "scene/contained_path.h"
#include "scene/export_folder.h"
#include "scene/mitsuba/current_words.h"
#include "scene/mitsuba/load.h"
#include "scene/mitsuba/mitsuba.h"
#include "scene/parameter_values.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <pugixml.hpp>
#include <sstream>

namespace cmpg {
namespace fs = std::filesystem;
namespace {

std::string listOf(std::span<const float> values) {
    std::string text;
    for (const float v : values) {
        char number[32];
        std::snprintf(number, sizeof number, "%.9g", double(v));
        text += (text.empty() ? "" : ", ") + std::string(number);
    }
    return text;
}

void addProperty(pugi::xml_node parent, const char* tag, const char* name, const std::string& value) {
    pugi::xml_node node = parent.append_child(tag);
    if (*name)
        node.append_attribute("name") = name;
    node.append_attribute("value") = value.c_str();
}

const char* nameOf(Wrap wrap) { return wrap == Wrap::Clamp ? "clamp" : wrap == Wrap::Mirror ? "mirror" : "repeat"; }

// As a matrix, which holds whatever the file had in its place.
void writeUvTransform(pugi::xml_node texture, const glm::mat3x2& m) {
    if (m == TextureAddress().uvTransform)
        return;
    pugi::xml_node transform = texture.append_child("transform");
    transform.append_attribute("name") = "to_uv";
    const float rows[] = {m[0].x, m[1].x, 0, m[2].x, m[0].y, m[1].y, 0, m[2].y, 0, 0, 1, 0, 0, 0, 0, 1};
    addProperty(transform, "matrix", "", listOf(rows));
}

// What version 0.6 has beside to_uv, and Mitsuba 3 refuses.
bool movesOldTexture(const std::string& property) {
    return property == "uscale" || property == "vscale" || property == "uoffset" || property == "voffset";
}

class Exporter {
  public:
    Exporter(const Scene& scene, const MitsubaLoad& source, const std::vector<std::uint32_t>& changed, ExportFolder& folder);
    pugi::xml_document run();

  private:
    pugi::xml_node write(pugi::xml_node parent, const MitsubaElement& element);
    bool isReplaced(const MitsubaElement& owner, const MitsubaElement& child) const;
    void findReferences(const MitsubaElement& element);
    void keepReferences(pugi::xml_node root, const MitsubaElement& element);
    void copyFile(const MitsubaElement& filename, pugi::xml_node written);
    void writeValue(pugi::xml_node parent, const std::string& property, const Parameter& parameter);
    void writeEnvironment(pugi::xml_node parent, const MitsubaElement* old);

    const Scene& scene_;
    const MitsubaLoad& source_;
    ExportFolder& folder_;
    std::map<const MitsubaElement*, std::map<std::string, std::uint32_t>> changed_; // by owner: parameters by property
    std::set<const MitsubaElement*> referenced_;                                    // by what is written as it was
    CurrentWords current_{source_.document};
    bool environment_ = false; // is written anew
};

Exporter::Exporter(const Scene& scene, const MitsubaLoad& source, const std::vector<std::uint32_t>& changed, ExportFolder& folder)
    : scene_(scene), source_(source), folder_(folder), environment_(scene.environment && scene.environment->replaced) {
    for (const std::uint32_t index : changed) {
        if (scene.environment && index == scene.environment->parameter)
            environment_ = true;
        else if (const auto origin = source.origins.find(scene.parameters.at(index).name); origin != source.origins.end())
            changed_[origin->second.owner][origin->second.property] = index;
    }
}

// To where it stands in the scene's folder, whatever way the name takes there, which may lead through a parent.
void Exporter::copyFile(const MitsubaElement& filename, pugi::xml_node written) {
    const std::string* name = filename.attribute("value");
    if (!name)
        return;
    const ContainedPath path = containedPath(source_.document.folder(), *name);
    if (!path.refusal.empty() || !fileExists(path.file))
        return; // nothing that is shown needs it, or the scene would not have loaded
    written.attribute("value") = folder_.copy(path.file, path.file.lexically_relative(source_.document.folder())).c_str();
}

// As the property's value; a texture keeps what it is looked up by.
void Exporter::writeValue(pugi::xml_node parent, const std::string& property, const Parameter& parameter) {
    const std::vector<float> values = valuesOf(parameter);
    if (!parameter.textured) {
        addProperty(parent, parameter.channels == 1 ? "float" : "rgb", property.c_str(), listOf(values));
        return;
    }
    const bool bright = parameter.highest() > 1, scalar = parameter.channels == 1;
    pugi::xml_node texture = parent.append_child("texture");
    texture.append_attribute("type") = "bitmap";
    texture.append_attribute("name") = property.c_str();
    const std::string stem = "textures/" + fileName(parameter.name);
    std::string file;
    if (bright) {
        file = folder_.add(stem, ".exr", encodeExr(imageOf(parameter)));
    } else {
        Bytes pixels;
        for (const float v : values)
            pixels.push_back(std::uint8_t(std::lround((scalar ? v : srgbEncode(v)) * 255)));
        file = folder_.add(stem, ".png", encodePng(pixels, int(parameter.width), int(parameter.height), int(parameter.channels)));
    }
    addProperty(texture, "string", "filename", file);
    addProperty(texture, "boolean", "raw", scalar || bright ? "true" : "false");
    addProperty(texture, "string", "filter_type", parameter.nearest ? "nearest" : "bilinear");
    addProperty(texture, "string", "wrap_mode", nameOf(parameter.wrapU));
    if (parameter.wrapV != parameter.wrapU) {
        addProperty(texture, "string", "wrap_mode_v", nameOf(parameter.wrapV));
        logWarn(parameter.name + ": along u its texture wraps as " + nameOf(parameter.wrapU) + ", along v as " + nameOf(parameter.wrapV) +
                ", for which Mitsuba 3 has no word: it refuses the written scene until wrap_mode_v is taken out");
    }
    writeUvTransform(texture, parameter.uvTransform);
}

void Exporter::writeEnvironment(pugi::xml_node parent, const MitsubaElement* old) {
    const Environment& environment = *scene_.environment;
    const Parameter& radiance = scene_.parameters[environment.parameter];
    pugi::xml_node node = parent.append_child("emitter");
    node.append_attribute("type") = radiance.textured ? "envmap" : "constant";
    if (old && !old->id.empty())
        node.append_attribute("id") = old->id.c_str();
    if (!radiance.textured) {
        addProperty(node, "rgb", "radiance", listOf(radiance.values));
        return;
    }
    addProperty(node, "string", "filename", folder_.add("environment", ".exr", encodeExr(imageOf(radiance))));
    if (!environment.replaced && old) { // as it stood
        for (const MitsubaElement* child : old->children)
            if (child->name == "to_world")
                write(node, *child);
    } else {
        pugi::xml_node turn = node.append_child("transform");
        turn.append_attribute("name") = "to_world";
        pugi::xml_node rotate = turn.append_child("rotate");
        rotate.append_attribute("y") = "1";
        rotate.append_attribute("angle") = glm::degrees(double(environment.rotation));
    }
}

bool Exporter::isReplaced(const MitsubaElement& owner, const MitsubaElement& child) const {
    const auto found = changed_.find(&owner);
    return found != changed_.end() && found->second.contains(child.name);
}

void Exporter::findReferences(const MitsubaElement& element) {
    if (const MitsubaElement* target = element.tag == "ref" ? source_.document.target(element) : nullptr)
        referenced_.insert(target);
    for (const MitsubaElement* child : element.children)
        if (!isReplaced(element, *child))
            findReferences(*child);
}

// A texture whose place another takes stays for those that refer to it: in the scene itself, before all else.
void Exporter::keepReferences(pugi::xml_node root, const MitsubaElement& element) {
    for (const MitsubaElement* child : element.children) {
        if (isReplaced(element, *child) && referenced_.contains(child))
            write(root, *child).remove_attribute("name");
        else
            keepReferences(root, *child);
    }
}

// Returns what became of the element, if anything did.
pugi::xml_node Exporter::write(pugi::xml_node parent, const MitsubaElement& old) {
    if (old.tag == "emitter" && environment_ && (old.type == "envmap" || old.type == "constant")) {
        if (!scene_.environment->replaced)
            writeEnvironment(parent, &old);
        return {};
    }
    const MitsubaElement element = current_.of(old);
    pugi::xml_node node = parent.append_child(element.tag.c_str());
    for (const auto& [key, value] : {std::pair("type", element.type), std::pair("id", element.id), std::pair("name", element.name)})
        if (!value.empty())
            node.append_attribute(key) = value.c_str();
    for (const auto& [key, value] : element.attributes)
        node.append_attribute(key.c_str()) = value.c_str();
    if (element.tag == "string" && element.name == "filename")
        copyFile(element, node);
    if (const MitsubaElement* target = element.tag == "ref" ? source_.document.target(element) : nullptr) // by an alias perhaps, which is not written
        node.attribute("id") = target->id.c_str();
    const auto found = changed_.find(&old);
    std::set<std::string> written;
    const bool moved = element.tag == "texture" &&
                       std::any_of(element.children.begin(), element.children.end(), [](const MitsubaElement* child) { return movesOldTexture(child->name); });
    for (const MitsubaElement* child : element.children) {
        if (moved && (movesOldTexture(child->name) || child->name == "to_uv"))
            continue;
        if (found != changed_.end())
            if (const auto value = found->second.find(child->name); value != found->second.end()) {
                writeValue(node, value->first, scene_.parameters[value->second]);
                written.insert(value->first);
                continue;
            }
        write(node, *child);
    }
    if (moved)
        writeUvTransform(node, mitsubaUvTransform(MitsubaObject(source_.document, element)));
    if (found == changed_.end())
        return node;
    for (const auto& [property, index] : found->second) // that kept its default in the file
        if (!written.contains(property))
            writeValue(node, property, scene_.parameters[index]);
    return node;
}

pugi::xml_document Exporter::run() {
    pugi::xml_document out;
    pugi::xml_node root = out.append_child("scene");
    root.append_attribute("version") = "3.0.0";
    for (const MitsubaElement* element : source_.document.contents())
        findReferences(*element);
    for (const MitsubaElement* element : source_.document.contents())
        keepReferences(root, *element);
    for (const MitsubaElement* element : source_.document.contents())
        write(root, *element);
    if (environment_ && scene_.environment->replaced)
        writeEnvironment(root, nullptr);
    return out;
}

} // namespace

void writeMitsuba(const Scene& scene, const std::vector<std::uint32_t>& changed, ExportFolder& out) {
    const MitsubaDocument document(scene.source, scene.definitions);
    LoadOptions options;
    options.definitions = scene.definitions;
    if (scene.environment && scene.environment->replaced)
        options.environment.file = scene.source; // the scene's own is not looked at
    MitsubaLoad source(document, options);
    orientMitsubaScene(source);
    loadMitsubaShapes(source); // says which element each parameter came from
    if (source.scene.parameters.size() > scene.parameters.size())
        throw Error(ErrorKind::Output, "cannot export " + scene.source, "the scene's file changed since it was loaded", "leave the scene in place during a run");
    const pugi::xml_document xml = Exporter(scene, source, changed, out).run();
    std::ostringstream text;
    xml.save(text, "  ");
    const std::string bytes = text.str();
    writeFile(out.path() / kMitsuba.exported, std::span(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()));
}

} // namespace cmpg
