// jpeg_decoder
