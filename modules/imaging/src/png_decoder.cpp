// png_decoder
