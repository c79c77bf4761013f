"""Faces for other heads: the default face's motion on a bare mesh, and its shape and paint fitted to photographs."""
