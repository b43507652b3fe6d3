# Draws a mesh under c1_phong.shader and saves the picture. test.mjs prepares mesh.json (positions, normals, PER_ROW
# triangles in each row of the texture) and coefficients.bin in the folder DATA, and compares the picture.
extends Spatial

func _ready():
	var folder = OS.get_environment("DATA")
	var file = File.new()
	file.open(folder + "/mesh.json", File.READ)
	var data = JSON.parse(file.get_as_text()).result
	file.open(folder + "/coefficients.bin", File.READ)
	var image = Image.new()
	image.create_from_data(data.width, data.height, false, Image.FORMAT_RGBAF, file.get_buffer(file.get_len()))
	var texture = ImageTexture.new()
	texture.create_from_image(image, 0)

	var positions = PoolVector3Array()
	var normals = PoolVector3Array()
	var corners = PoolVector2Array()
	for i in range(0, data.positions.size() / 3):
		var place = [3 * i, 3 * i + 1, 3 * i + 2]
		positions.append(Vector3(data.positions[place[0]], data.positions[place[1]], data.positions[place[2]]))
		normals.append(Vector3(data.normals[place[0]], data.normals[place[1]], data.normals[place[2]]))
		corners.append(Vector2(i / 3, i % 3))
	var arrays = []
	arrays.resize(Mesh.ARRAY_MAX)
	arrays[Mesh.ARRAY_VERTEX] = positions
	arrays[Mesh.ARRAY_NORMAL] = normals
	arrays[Mesh.ARRAY_TEX_UV2] = corners
	var mesh = ArrayMesh.new()
	# Without compression: triangles are counted in UV2.
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays, [], 0)

	# The lighting of `machband shade`, in place of Godot's, so that the pictures can be compared.
	var code = load("res://c1_phong.shader").code
	code = code.replace("shader_type spatial;", "shader_type spatial;\nrender_mode unshaded, cull_disabled;")
	code = code.replace("// Your material goes here.", """
	vec3 lamp = normalize(vec3(0.36, 0.48, 0.8));
	float cosine = dot(NORMAL, lamp);
	float shine = max(2.0 * cosine * NORMAL.z - lamp.z, 0.0);
	ALBEDO = vec3(0.1) + (cosine > 0.0 ? 0.6 * cosine + 0.3 * pow(shine, 20.0) : 0.0);""")
	var shader = Shader.new()
	shader.code = code
	var material = ShaderMaterial.new()
	material.shader = shader
	material.set_shader_param("coefficients", texture)
	var shown = MeshInstance.new()
	shown.mesh = mesh
	shown.material_override = material
	add_child(shown)
	var camera = Camera.new()
	camera.set_orthogonal(data.size, 0.1, 10.0)
	camera.translation = Vector3(0, 0, 5)
	add_child(camera)
	camera.make_current()
	for _frame in range(4):
		yield(VisualServer, "frame_post_draw")
	var picture = get_viewport().get_texture().get_data()
	picture.flip_y()
	picture.convert(Image.FORMAT_RGB8)
	picture.save_png(folder + "/picture.png")
	get_tree().quit()
