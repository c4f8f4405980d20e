// image_reader
