// image_info
